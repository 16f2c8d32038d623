#include "anatomesh/pipeline/attempts.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace anatomesh {
namespace {

const TryOutcome good{true, false, false, false, false, 0.001, 100000};
const TryOutcome broken{false, true, false, false, false, 0, 0};
const TryOutcome broken_spared{false, true, true, false, false, 0, 0};
const TryOutcome ill_shaped{true, false, false, false, false, 0.0055, 100000};
const TryOutcome torn{true, false, false, true, false, 0.001, 100000};

TryOutcome with_cells(TryOutcome outcome, std::size_t cells) {
    outcome.cells = cells;
    return outcome;
}

// Tries as often as it is told to, always with that outcome.
std::vector<NextTry> all_tries(const TryOutcome& always, bool size_given) {
    Attempts attempts(size_given);
    std::vector<NextTry> tries;
    do tries.push_back(attempts.next(always));
    while (tries.back() != NextTry::none && tries.size() < 100);
    return tries;
}

TEST(Attempts, AGoodModelIsTheLast) {
    for (const bool given : {false, true}) EXPECT_EQ(all_tries(good, given), std::vector{NextTry::none});
}

TEST(Attempts, OfEveryOutcomeTheTriesEnd) {
    for (unsigned bits = 0; bits < 128; ++bits) {
        const TryOutcome outcome{(bits & 1) != 0,
                                 (bits & 2) != 0,
                                 (bits & 4) != 0,
                                 (bits & 8) != 0,
                                 (bits & 64) != 0,
                                 bits & 16 ? 0.5 : 0.0,
                                 bits & 32 ? Attempts::again_below : std::size_t{10}};
        for (const bool given : {false, true}) {
            const std::vector<NextTry> tries = all_tries(outcome, given);
            EXPECT_LE(tries.size(), Attempts::most_finer + Attempts::most_same + 1) << bits;
            if (!given) continue;
            for (const NextTry next : tries) EXPECT_NE(next, NextTry::finer) << bits;
        }
    }
}

TEST(Attempts, WhatConformedBadlyIsBuiltAgainAtTheSameSizeWithoutThat) {
    for (const bool given : {false, true}) {
        Attempts attempts(given);
        EXPECT_EQ(attempts.next({true, false, true, false, true, 0.001, 100000}), NextTry::same_size);
        EXPECT_EQ(attempts.next(good), NextTry::none);
    }
}

TEST(Attempts, AllTheWorkIsDoneBeforeFinerCells) {
    Attempts attempts(false);
    EXPECT_EQ(attempts.next(broken_spared), NextTry::same_size);
    EXPECT_EQ(attempts.next(broken), NextTry::finer);
    EXPECT_EQ(attempts.next(good), NextTry::none);
}

TEST(Attempts, WhatNoSizeMendsIsNotTriedAgain) {
    TryOutcome wrong = broken;
    wrong.size_matters = false;
    EXPECT_EQ(all_tries(wrong, false), std::vector{NextTry::none});
}

// Two contours a hundredth of an edge from each other: any size has ill-shaped cells there.
TEST(Attempts, ForTheShapesOnlyOneTryIsFiner) {
    EXPECT_EQ(all_tries(ill_shaped, false), (std::vector{NextTry::finer, NextTry::none}));
    EXPECT_EQ(all_tries(ill_shaped, true), std::vector{NextTry::none});
    EXPECT_EQ(all_tries(with_cells(ill_shaped, Attempts::again_below), false), std::vector{NextTry::none});
    Attempts attempts(false);
    EXPECT_EQ(attempts.next(ill_shaped), NextTry::finer);
    EXPECT_TRUE(attempts.finer_for_shape());
    EXPECT_EQ(attempts.next(broken), NextTry::none) << "the coarser one kept the contract";
}

TEST(Attempts, TornWallsAreTriedFinerWhileTheyAreTorn) {
    EXPECT_EQ(all_tries(torn, false),
              (std::vector{NextTry::finer, NextTry::finer, NextTry::finer, NextTry::none}));
    EXPECT_EQ(all_tries(torn, true), std::vector{NextTry::none});
}

}  // namespace
}  // namespace anatomesh
