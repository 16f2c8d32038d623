#include "anatomesh/pipeline/retry/attempts.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace anatomesh {
namespace {

const TryOutcome good{.kept_contract = true, .over_bound = 0.001, .cells = 100000};
const TryOutcome broken{.size_matters = true};
const TryOutcome broken_spared{.size_matters = true, .spared_work = true};
const TryOutcome ill_shaped{.kept_contract = true, .over_bound = 0.0055, .cells = 100000};
const TryOutcome torn{.kept_contract = true, .tore_walls = true, .over_bound = 0.001, .cells = 100000};
// Contour segments were split for each other's sake.
const TryOutcome broken_conformed{
    .size_matters = true, .spared_work = true, .conformed = true, .cells = 50000};
const TryOutcome conformed_badly{.kept_contract = true,
                                 .spared_work = true,
                                 .conformed = true,
                                 .conformed_badly = true,
                                 .over_bound = 0.001,
                                 .cells = 50000};

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
    for (unsigned bits = 0; bits < 256; ++bits) {
        const TryOutcome outcome{.kept_contract = (bits & 1) != 0,
                                 .size_matters = (bits & 2) != 0,
                                 .spared_work = (bits & 4) != 0,
                                 .tore_walls = (bits & 8) != 0,
                                 .conformed = (bits & 128) != 0,
                                 .conformed_badly = (bits & 64) != 0,
                                 .over_bound = bits & 16 ? 0.5 : 0.0,
                                 .cells = bits & 32 ? Attempts::again_below : std::size_t{10}};
        for (const bool given : {false, true}) {
            const std::vector<NextTry> tries = all_tries(outcome, given);
            EXPECT_LE(tries.size(),
                      Attempts::most_finer + Attempts::most_same + Attempts::most_conforming + 1)
                << bits;
            if (!given) continue;
            for (const NextTry next : tries)
                EXPECT_TRUE(next == NextTry::none || next == NextTry::same_size) << bits;
        }
    }
}

// A few ill-shaped cells in tens of thousands are luck: another edge length has others.
TEST(Attempts, WhatConformedBadlyIsTriedSlightlyFinerAndOnlyThenWithoutThat) {
    for (const TryOutcome& bad : {broken_conformed, conformed_badly}) {
        Attempts attempts(false);
        for (std::size_t n = 1; n <= Attempts::most_conforming; ++n) {
            EXPECT_EQ(attempts.next(bad), NextTry::slightly_finer);
            EXPECT_EQ(attempts.slightly_finer(), n);
        }
        EXPECT_EQ(attempts.next(bad), NextTry::same_size);
        EXPECT_EQ(attempts.next(broken), NextTry::finer);
        Attempts lucky(false);
        EXPECT_EQ(lucky.next(bad), NextTry::slightly_finer);
        EXPECT_EQ(lucky.next(good), NextTry::none);
    }
}

// A limit that shorter edges meet is none of the model with the edges before.
TEST(Attempts, WhereASlightlyFinerOneStopsItIsBuiltWithoutThat) {
    const TryOutcome stopped{.conformed = true};
    Attempts attempts(false);
    EXPECT_EQ(attempts.next(broken_conformed), NextTry::slightly_finer);
    EXPECT_EQ(attempts.next(stopped), NextTry::same_size);
    EXPECT_EQ(Attempts(false).next(stopped), NextTry::none);
}

TEST(Attempts, WhatConformedBadlyAndIsLargeOrOfAGivenSizeIsBuiltWithoutThatAtOnce) {
    for (const TryOutcome& bad : {broken_conformed, conformed_badly}) {
        EXPECT_EQ(Attempts(true).next(bad), NextTry::same_size);
        EXPECT_EQ(Attempts(false).next(with_cells(bad, Attempts::conforming_below)), NextTry::same_size);
        TryOutcome full = bad;
        full.unforced = 0.011;
        EXPECT_EQ(Attempts(false).next(full), NextTry::same_size);
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

const TryOutcome half_the_contours{.kept_contract = true, .missed = 0.2, .tangles = 4, .farthest = 0.3};

TryOutcome with_contours(double missed, long long tangles, double bad = 0, double farthest = 0.4) {
    TryOutcome outcome = conformed_badly;
    outcome.missed = missed;
    outcome.tangles = tangles;
    outcome.bad = bad;
    outcome.farthest = farthest;
    return outcome;
}

TEST(Attempts, ContoursAreWorthSingleBadCellsButNoHandles) {
    const auto kept = [](const TryOutcome& outcome) { return has_more_contours(outcome, half_the_contours); };
    EXPECT_TRUE(kept(with_contours(0.14, 4)));
    EXPECT_FALSE(kept(with_contours(0.16, 4))) << "hardly more contours";
    EXPECT_FALSE(kept(with_contours(0.14, 6))) << "handles";
    EXPECT_TRUE(kept(with_contours(0.09, 8))) << "lacks less than half";
    EXPECT_FALSE(kept(with_contours(0.09, 9)));
    EXPECT_TRUE(kept(with_contours(0.04, 16)));
    EXPECT_TRUE(kept(with_contours(0, 16)));
    EXPECT_FALSE(kept(with_contours(0, 17))) << "four times the handles";
    EXPECT_TRUE(kept(with_contours(0.09, 4, 9e-4)));
    EXPECT_FALSE(kept(with_contours(0.09, 4, 2e-3))) << "more than single bad cells";
    EXPECT_FALSE(kept(with_contours(0.09, 4, 0, 0.6))) << "a spike that a warning tells of";
    TryOutcome far = half_the_contours;
    far.farthest = 0.52;
    EXPECT_TRUE(has_more_contours(with_contours(0.09, 4, 0, 0.64), far));
    EXPECT_FALSE(has_more_contours(with_contours(0.09, 4, 0, 0.66), far))
        << "and more than the other one has";
    TryOutcome torn_walls = with_contours(0.09, 4);
    torn_walls.tore_walls = true;
    EXPECT_FALSE(kept(torn_walls));
    EXPECT_FALSE(has_more_contours(half_the_contours, half_the_contours)) << "did not conform";
}

TEST(Attempts, OneThatMeetsAllClausesMayGoFartherThanOneThatDoesNot) {
    TryOutcome other = half_the_contours;
    other.unmet = 1;
    EXPECT_TRUE(has_more_contours(with_contours(0.09, 4, 0, 0.75), other));
    EXPECT_FALSE(has_more_contours(with_contours(0.09, 4, 0, 0.76), other));
    for (int what = 0; what < 2; ++what) {
        TryOutcome kept = with_contours(0.09, 4, 0, 0.6);
        (what == 0 ? kept.unmet : kept.untold) = 1;
        EXPECT_FALSE(has_more_contours(kept, other)) << what;
    }
}

TEST(Attempts, WhereTheModelThatIsKeptHasMoreContoursNoFinerOneIsTried) {
    TryOutcome other = half_the_contours;
    other.over_bound = ill_shaped.over_bound;
    EXPECT_EQ(Attempts(false).next(other), NextTry::finer);
    for (const double missed : {0.0, 0.14}) {
        const TryOutcome kept = with_contours(missed, 4);
        EXPECT_EQ(Attempts(false).next(other, &kept), NextTry::none) << missed;
    }
    const TryOutcome few = with_contours(0.16, 4);
    EXPECT_EQ(Attempts(false).next(other, &few), NextTry::finer) << "hardly more contours";
    const TryOutcome kept = with_contours(0, 4);
    EXPECT_EQ(Attempts(false).next(broken, &kept), NextTry::finer) << "no model to take it for";
}

TEST(Attempts, WhatIsHardlyBadIsNotTriedWithoutItsContours) {
    for (const bool astray : {false, true}) {
        TryOutcome kept = with_contours(0.01, 4, 1e-4, 0.5);
        kept.astray = astray;
        EXPECT_TRUE(is_hardly_bad(kept));
        TryOutcome worse = kept;
        worse.bad = 2e-4;
        EXPECT_FALSE(is_hardly_bad(worse));
        worse = kept;
        worse.tore_walls = true;
        EXPECT_FALSE(is_hardly_bad(worse));
        worse = kept;
        worse.farthest = 0.51;
        EXPECT_EQ(is_hardly_bad(worse), !astray) << "a spike that a warning tells of";
    }
    EXPECT_FALSE(is_hardly_bad(good)) << "nothing is bad";
}

TEST(Attempts, WhereNothingIsGainedTheOneThatConformedIsNotKept) {
    for (const double missed : {0.0, 0.0001, 0.004}) {
        TryOutcome other = half_the_contours;
        other.missed = missed;
        EXPECT_FALSE(has_more_contours(with_contours(0, 4), other)) << missed;
    }
    TryOutcome conformed = half_the_contours;
    conformed.conformed = true;
    EXPECT_FALSE(has_more_contours(with_contours(0.09, 4), conformed)) << "a finer one, and a good one";
}

TEST(Attempts, ASmallModelThatDoesNotMeetAllClausesMayDoSoWithShorterEdges) {
    EXPECT_FALSE(may_meet_all_clauses(with_cells(good, 50000), 1)) << "it meets all";
    TryOutcome lacking = with_cells(good, 50000);
    lacking.unmet = 1;
    for (const std::size_t tries : {1, 3, 6}) EXPECT_TRUE(may_meet_all_clauses(lacking, tries));
    EXPECT_FALSE(may_meet_all_clauses(lacking, 7)) << "its tries are no luck";
    EXPECT_FALSE(may_meet_all_clauses(with_cells(lacking, 100000), 1)) << "its tries take long";
    lacking.contradicted = true;
    EXPECT_FALSE(may_meet_all_clauses(lacking, 1)) << "no model has all";
    lacking.contradicted = false;
    lacking.kept_contract = false;
    EXPECT_FALSE(may_meet_all_clauses(lacking, 1));
}

TEST(Attempts, OneThatHasTheContoursIsTakenUnlessItIsJoinedOtherwise) {
    TryOutcome kept = with_cells(good, 50000);
    kept.lacks_contours = true;
    kept.unmet = 1;
    TryOutcome later = kept;
    EXPECT_FALSE(meets_more_clauses(later, kept));
    later.lacks_contours = false;
    EXPECT_FALSE(meets_more_clauses(later, kept)) << "another clause is not met in its place";
    later.unmet = 0;
    EXPECT_TRUE(meets_more_clauses(later, kept));
    later.untold = 1;
    EXPECT_FALSE(meets_more_clauses(later, kept)) << "joined otherwise than drawn";
    later.tangles = kept.tangles - 1;
    EXPECT_TRUE(meets_more_clauses(later, kept)) << "elsewhere less than before";
    later.tore_walls = true;
    EXPECT_FALSE(meets_more_clauses(later, kept));
    later.tore_walls = false;
    later.farthest = 0.51;
    EXPECT_FALSE(meets_more_clauses(later, kept)) << "a spike that a warning tells of";
    later.farthest = 0.5;
    EXPECT_TRUE(meets_more_clauses(later, kept));
    kept.farthest = 0.3;
    later.farthest = 0.6;
    EXPECT_TRUE(meets_more_clauses(later, kept)) << "not much further";
    kept.farthest = later.farthest = 0;
    later.untold = 0;
    later.tangles = kept.tangles;
    later.kept_contract = false;
    EXPECT_FALSE(meets_more_clauses(later, kept));
    kept.unmet = 2;
    later = kept;
    later.unmet = 1;
    EXPECT_TRUE(meets_more_clauses(later, kept)) << "it lacks no more contours";
    later.missed = kept.missed + 1e-4;
    EXPECT_FALSE(meets_more_clauses(later, kept)) << "it lacks more";
}

TEST(Attempts, AModelOfWhichContoursDoNotTellAllIsTangled) {
    EXPECT_FALSE(is_tangled(good));
    TryOutcome tangled = with_cells(good, 50000);
    tangled.untold = 1;
    EXPECT_TRUE(is_tangled(tangled));
    EXPECT_FALSE(is_tangled(with_cells(tangled, 100000))) << "its tries take long";
    tangled.kept_contract = false;
    EXPECT_FALSE(is_tangled(tangled));
}

TEST(Attempts, OneThatIsLessTangledAndNoWorseIsTakenInItsPlace) {
    TryOutcome kept = with_cells(good, 50000);
    kept.untold = 2;
    TryOutcome later = kept;
    EXPECT_FALSE(is_less_tangled(later, kept));
    for (const std::size_t untold : {0, 1}) {
        later = kept;
        later.untold = untold;
        EXPECT_TRUE(is_less_tangled(later, kept));
        later.unmet = 1;
        EXPECT_FALSE(is_less_tangled(later, kept)) << "a clause is not met";
        later.unmet = 0;
        later.missed = 1e-2;
        EXPECT_FALSE(is_less_tangled(later, kept)) << "contour segments are lost";
        later.missed = 0;
        later.astray = true;
        EXPECT_FALSE(is_less_tangled(later, kept));
        later.astray = false;
        later.kept_contract = false;
        EXPECT_FALSE(is_less_tangled(later, kept));
    }
    kept.unmet = 1;
    kept.missed = 0.2;
    kept.astray = true;
    later = kept;
    later.untold = 1;
    EXPECT_TRUE(is_less_tangled(later, kept)) << "no worse than it was";
}

TEST(Attempts, OfTwoAlikeWithFewBadCellsTheLaterOneIsTaken) {
    for (const double missed : {0.0, 0.1}) {
        for (const double bad : {0.0, 5e-5}) {
            for (const bool astray : {false, true}) {
                TryOutcome outcome = with_contours(missed, 4, bad);
                outcome.astray = astray;
                EXPECT_FALSE(is_worse(outcome, outcome));
            }
        }
    }
}

TEST(Attempts, OfTwoAstrayTheOneWithMoreContoursOrFewerHandlesIsKept) {
    const auto astray = [](double missed, long long tangles) {
        TryOutcome outcome = with_contours(missed, tangles);
        outcome.astray = true;
        return outcome;
    };
    EXPECT_TRUE(is_worse(astray(0.2, 4), astray(0.1, 4)));
    EXPECT_TRUE(is_worse(astray(0.1, 14), astray(0.1, 8)));
    EXPECT_FALSE(is_worse(astray(0.05, 14), astray(0.1, 8)));
    EXPECT_FALSE(is_worse(astray(0.1, 8), astray(0.1, 14)));
    EXPECT_TRUE(is_worse(astray(0.05, 4), with_contours(0.2, 4))) << "one that is not astray comes first";
    TryOutcome far = astray(0.05, 4);
    far.farthest = 0.8;
    EXPECT_TRUE(is_worse(far, astray(0.2, 8))) << "a spike that a warning tells of";
    EXPECT_FALSE(is_worse(astray(0.2, 8), far));
    EXPECT_FALSE(is_worse(far, far));
}

TEST(Attempts, OneThatMeetsAllClausesComesBeforeOneThatDoesNot) {
    const TryOutcome lacking = [] {
        TryOutcome outcome = with_contours(0, 4, 2e-4, 0.2);
        outcome.unmet = 1;
        return outcome;
    }();
    TryOutcome whole = with_contours(0.01, 4, 0, 0.5);
    whole.astray = true;
    EXPECT_FALSE(is_worse(whole, lacking));
    EXPECT_TRUE(is_worse(lacking, whole));
    whole.farthest = 0.51;
    EXPECT_TRUE(is_worse(whole, lacking)) << "a spike that a warning tells of";
}

}  // namespace
}  // namespace anatomesh
