#include "anatomesh/pipeline/retry/retry_policy.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace anatomesh::retry_policy_test {
namespace {

const RunScore good{.kept_contract = true, .over_bound = 0.001, .cells = 100000};
const RunScore broken{.size_matters = true};
const RunScore broken_spared{.size_matters = true, .reduced_effort = true};
const RunScore ill_shaped{.kept_contract = true, .over_bound = 0.0055, .cells = 100000};
const RunScore torn{.kept_contract = true, .torn = true, .over_bound = 0.001, .cells = 100000};
// Contour segments were split for each other's sake.
const RunScore broken_conformed{
    .size_matters = true, .reduced_effort = true, .conformed = true, .cells = 50000};
const RunScore conformed_badly{.kept_contract = true,
                               .reduced_effort = true,
                               .conformed = true,
                               .conformed_badly = true,
                               .over_bound = 0.001,
                               .cells = 50000};

RunScore with_cells(RunScore score, std::size_t cells) {
    score.cells = cells;
    return score;
}

// Tries as often as it is told to, always with that outcome.
std::vector<NextRun> all_runs(const RunScore& always, bool size_given) {
    RetryPolicy policy(size_given);
    std::vector<NextRun> runs;
    do runs.push_back(policy.next(always));
    while (runs.back() != NextRun::none && runs.size() < 100);
    return runs;
}

TEST(RetryPolicy, AGoodModelIsTheLast) {
    for (const bool given : {false, true}) EXPECT_EQ(all_runs(good, given), std::vector{NextRun::none});
}

TEST(RetryPolicy, OfEveryOutcomeTheTriesEnd) {
    for (unsigned bits = 0; bits < 256; ++bits) {
        const RunScore score{.kept_contract = (bits & 1) != 0,
                             .size_matters = (bits & 2) != 0,
                             .reduced_effort = (bits & 4) != 0,
                             .torn = (bits & 8) != 0,
                             .conformed = (bits & 128) != 0,
                             .conformed_badly = (bits & 64) != 0,
                             .over_bound = bits & 16 ? 0.5 : 0.0,
                             .cells = bits & 32 ? RetryPolicy::again_below : std::size_t{10}};
        for (const bool given : {false, true}) {
            const std::vector<NextRun> runs = all_runs(score, given);
            EXPECT_LE(runs.size(),
                      RetryPolicy::most_finer + RetryPolicy::most_same + RetryPolicy::most_conforming + 1)
                << bits;
            if (!given) continue;
            for (const NextRun next : runs)
                EXPECT_TRUE(next == NextRun::none || next == NextRun::same_size) << bits;
        }
    }
}

// A few ill-shaped cells in tens of thousands are luck: another edge length has others.
TEST(RetryPolicy, WhatConformedBadlyIsTriedSlightlyFinerAndOnlyThenWithoutThat) {
    for (const RunScore& bad : {broken_conformed, conformed_badly}) {
        RetryPolicy policy(false);
        for (std::size_t n = 1; n <= RetryPolicy::most_conforming; ++n) {
            EXPECT_EQ(policy.next(bad), NextRun::slightly_finer);
            EXPECT_EQ(policy.slightly_finer(), n);
        }
        EXPECT_EQ(policy.next(bad), NextRun::same_size);
        EXPECT_EQ(policy.next(broken), NextRun::finer);
        RetryPolicy lucky(false);
        EXPECT_EQ(lucky.next(bad), NextRun::slightly_finer);
        EXPECT_EQ(lucky.next(good), NextRun::none);
    }
}

// A limit that shorter edges meet is none of the model with the edges before.
TEST(RetryPolicy, WhereASlightlyFinerOneStopsItIsBuiltWithoutThat) {
    const RunScore stopped{.conformed = true};
    RetryPolicy policy(false);
    EXPECT_EQ(policy.next(broken_conformed), NextRun::slightly_finer);
    EXPECT_EQ(policy.next(stopped), NextRun::same_size);
    EXPECT_EQ(RetryPolicy(false).next(stopped), NextRun::none);
}

TEST(RetryPolicy, WhatConformedBadlyAndIsLargeOrOfAGivenSizeIsBuiltWithoutThatAtOnce) {
    for (const RunScore& bad : {broken_conformed, conformed_badly}) {
        EXPECT_EQ(RetryPolicy(true).next(bad), NextRun::same_size);
        EXPECT_EQ(RetryPolicy(false).next(with_cells(bad, RetryPolicy::conforming_below)),
                  NextRun::same_size);
        RunScore full = bad;
        full.unforced = 0.011;
        EXPECT_EQ(RetryPolicy(false).next(full), NextRun::same_size);
    }
}

TEST(RetryPolicy, AllTheWorkIsDoneBeforeFinerCells) {
    RetryPolicy policy(false);
    EXPECT_EQ(policy.next(broken_spared), NextRun::same_size);
    EXPECT_EQ(policy.next(broken), NextRun::finer);
    EXPECT_EQ(policy.next(good), NextRun::none);
}

TEST(RetryPolicy, WhatNoSizeMendsIsNotTriedAgain) {
    RunScore wrong = broken;
    wrong.size_matters = false;
    EXPECT_EQ(all_runs(wrong, false), std::vector{NextRun::none});
}

// Two contours a hundredth of an edge from each other: any size has ill-shaped cells there.
TEST(RetryPolicy, ForTheShapesOnlyOneTryIsFiner) {
    EXPECT_EQ(all_runs(ill_shaped, false), (std::vector{NextRun::finer, NextRun::none}));
    EXPECT_EQ(all_runs(ill_shaped, true), std::vector{NextRun::none});
    EXPECT_EQ(all_runs(with_cells(ill_shaped, RetryPolicy::again_below), false), std::vector{NextRun::none});
    RetryPolicy policy(false);
    EXPECT_EQ(policy.next(ill_shaped), NextRun::finer);
    EXPECT_TRUE(policy.finer_for_shape());
    EXPECT_EQ(policy.next(broken), NextRun::none) << "the coarser one kept the contract";
}

TEST(RetryPolicy, TornWallsAreTriedFinerWhileTheyAreTorn) {
    EXPECT_EQ(all_runs(torn, false),
              (std::vector{NextRun::finer, NextRun::finer, NextRun::finer, NextRun::none}));
    EXPECT_EQ(all_runs(torn, true), std::vector{NextRun::none});
}

const RunScore half_the_contours{
    .kept_contract = true, .missed = 0.2, .components_and_handles = 4, .farthest = 0.3};

RunScore with_contours(double missed, long long components_and_handles, double bad = 0,
                       double farthest = 0.4) {
    RunScore score = conformed_badly;
    score.missed = missed;
    score.components_and_handles = components_and_handles;
    score.bad = bad;
    score.farthest = farthest;
    return score;
}

TEST(RetryPolicy, ContoursAreWorthSingleBadCellsButNoHandles) {
    const auto kept = [](const RunScore& score) { return has_more_contours(score, half_the_contours); };
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
    RunScore far = half_the_contours;
    far.farthest = 0.52;
    EXPECT_TRUE(has_more_contours(with_contours(0.09, 4, 0, 0.64), far));
    EXPECT_FALSE(has_more_contours(with_contours(0.09, 4, 0, 0.66), far))
        << "and more than the other one has";
    RunScore torn_walls = with_contours(0.09, 4);
    torn_walls.torn = true;
    EXPECT_FALSE(kept(torn_walls));
    EXPECT_FALSE(has_more_contours(half_the_contours, half_the_contours)) << "did not conform";
}

TEST(RetryPolicy, OneThatMeetsAllClausesMayGoFartherThanOneThatDoesNot) {
    RunScore other = half_the_contours;
    other.unmet_clauses = 1;
    EXPECT_TRUE(has_more_contours(with_contours(0.09, 4, 0, 0.75), other));
    EXPECT_FALSE(has_more_contours(with_contours(0.09, 4, 0, 0.76), other));
    for (int what = 0; what < 2; ++what) {
        RunScore kept = with_contours(0.09, 4, 0, 0.6);
        (what == 0 ? kept.unmet_clauses : kept.spurious_joints) = 1;
        EXPECT_FALSE(has_more_contours(kept, other)) << what;
    }
}

TEST(RetryPolicy, WhereTheModelThatIsKeptHasMoreContoursNoFinerOneIsTried) {
    RunScore other = half_the_contours;
    other.over_bound = ill_shaped.over_bound;
    EXPECT_EQ(RetryPolicy(false).next(other), NextRun::finer);
    for (const double missed : {0.0, 0.14}) {
        const RunScore kept = with_contours(missed, 4);
        EXPECT_EQ(RetryPolicy(false).next(other, &kept), NextRun::none) << missed;
    }
    const RunScore few = with_contours(0.16, 4);
    EXPECT_EQ(RetryPolicy(false).next(other, &few), NextRun::finer) << "hardly more contours";
    const RunScore kept = with_contours(0, 4);
    EXPECT_EQ(RetryPolicy(false).next(broken, &kept), NextRun::finer) << "no model to take it for";
}

TEST(RetryPolicy, WhatIsHardlyBadIsNotTriedWithoutItsContours) {
    for (const bool deviates : {false, true}) {
        RunScore kept = with_contours(0.01, 4, 1e-4, 0.5);
        kept.deviates = deviates;
        EXPECT_TRUE(is_hardly_bad(kept));
        RunScore worse = kept;
        worse.bad = 2e-4;
        EXPECT_FALSE(is_hardly_bad(worse));
        worse = kept;
        worse.torn = true;
        EXPECT_FALSE(is_hardly_bad(worse));
        worse = kept;
        worse.farthest = 0.51;
        EXPECT_EQ(is_hardly_bad(worse), !deviates) << "a spike that a warning tells of";
    }
    EXPECT_FALSE(is_hardly_bad(good)) << "nothing is bad";
}

TEST(RetryPolicy, WhereNothingIsGainedTheOneThatConformedIsNotKept) {
    for (const double missed : {0.0, 0.0001, 0.004}) {
        RunScore other = half_the_contours;
        other.missed = missed;
        EXPECT_FALSE(has_more_contours(with_contours(0, 4), other)) << missed;
    }
    RunScore conformed = half_the_contours;
    conformed.conformed = true;
    EXPECT_FALSE(has_more_contours(with_contours(0.09, 4), conformed)) << "a finer one, and a good one";
}

TEST(RetryPolicy, ASmallModelThatDoesNotMeetAllClausesMayDoSoWithShorterEdges) {
    EXPECT_FALSE(may_meet_all_clauses(with_cells(good, 50000), 1)) << "it meets all";
    RunScore lacking = with_cells(good, 50000);
    lacking.unmet_clauses = 1;
    for (const std::size_t runs : {1, 3, 6}) EXPECT_TRUE(may_meet_all_clauses(lacking, runs));
    EXPECT_FALSE(may_meet_all_clauses(lacking, 7)) << "its tries are no luck";
    EXPECT_FALSE(may_meet_all_clauses(with_cells(lacking, 100000), 1)) << "its tries take long";
    lacking.contradicted = true;
    EXPECT_FALSE(may_meet_all_clauses(lacking, 1)) << "no model has all";
    lacking.contradicted = false;
    lacking.kept_contract = false;
    EXPECT_FALSE(may_meet_all_clauses(lacking, 1));
}

TEST(RetryPolicy, OneThatHasTheContoursIsTakenUnlessItIsJoinedOtherwise) {
    RunScore kept = with_cells(good, 50000);
    kept.lacks_contours = true;
    kept.unmet_clauses = 1;
    RunScore later = kept;
    EXPECT_FALSE(meets_more_clauses(later, kept));
    later.lacks_contours = false;
    EXPECT_FALSE(meets_more_clauses(later, kept)) << "another clause is not met in its place";
    later.unmet_clauses = 0;
    EXPECT_TRUE(meets_more_clauses(later, kept));
    later.spurious_joints = 1;
    EXPECT_FALSE(meets_more_clauses(later, kept)) << "joined otherwise than drawn";
    later.components_and_handles = kept.components_and_handles - 1;
    EXPECT_TRUE(meets_more_clauses(later, kept)) << "elsewhere less than before";
    later.torn = true;
    EXPECT_FALSE(meets_more_clauses(later, kept));
    later.torn = false;
    later.farthest = 0.51;
    EXPECT_FALSE(meets_more_clauses(later, kept)) << "a spike that a warning tells of";
    later.farthest = 0.5;
    EXPECT_TRUE(meets_more_clauses(later, kept));
    kept.farthest = 0.3;
    later.farthest = 0.6;
    EXPECT_TRUE(meets_more_clauses(later, kept)) << "not much further";
    kept.farthest = later.farthest = 0;
    later.spurious_joints = 0;
    later.components_and_handles = kept.components_and_handles;
    later.kept_contract = false;
    EXPECT_FALSE(meets_more_clauses(later, kept));
    kept.unmet_clauses = 2;
    later = kept;
    later.unmet_clauses = 1;
    EXPECT_TRUE(meets_more_clauses(later, kept)) << "it lacks no more contours";
    later.missed = kept.missed + 1e-4;
    EXPECT_FALSE(meets_more_clauses(later, kept)) << "it lacks more";
}

TEST(RetryPolicy, AModelOfWhichContoursDoNotTellAllIsTangled) {
    EXPECT_FALSE(is_tangled(good));
    RunScore tangled = with_cells(good, 50000);
    tangled.spurious_joints = 1;
    EXPECT_TRUE(is_tangled(tangled));
    EXPECT_FALSE(is_tangled(with_cells(tangled, 100000))) << "its tries take long";
    tangled.kept_contract = false;
    EXPECT_FALSE(is_tangled(tangled));
}

TEST(RetryPolicy, OneThatIsLessTangledAndNoWorseIsTakenInItsPlace) {
    RunScore kept = with_cells(good, 50000);
    kept.spurious_joints = 2;
    RunScore later = kept;
    EXPECT_FALSE(is_less_tangled(later, kept));
    for (const std::size_t spurious_joints : {0, 1}) {
        later = kept;
        later.spurious_joints = spurious_joints;
        EXPECT_TRUE(is_less_tangled(later, kept));
        later.unmet_clauses = 1;
        EXPECT_FALSE(is_less_tangled(later, kept)) << "a clause is not met";
        later.unmet_clauses = 0;
        later.missed = 1e-2;
        EXPECT_FALSE(is_less_tangled(later, kept)) << "contour segments are lost";
        later.missed = 0;
        later.deviates = true;
        EXPECT_FALSE(is_less_tangled(later, kept));
        later.deviates = false;
        later.kept_contract = false;
        EXPECT_FALSE(is_less_tangled(later, kept));
    }
    kept.unmet_clauses = 1;
    kept.missed = 0.2;
    kept.deviates = true;
    later = kept;
    later.spurious_joints = 1;
    EXPECT_TRUE(is_less_tangled(later, kept)) << "no worse than it was";
}

TEST(RetryPolicy, OfTwoAlikeWithFewBadCellsTheLaterOneIsTaken) {
    for (const double missed : {0.0, 0.1}) {
        for (const double bad : {0.0, 5e-5}) {
            for (const bool deviates : {false, true}) {
                RunScore score = with_contours(missed, 4, bad);
                score.deviates = deviates;
                EXPECT_FALSE(is_worse(score, score));
            }
        }
    }
}

TEST(RetryPolicy, OfTwoAstrayTheOneWithMoreContoursOrFewerHandlesIsKept) {
    const auto deviates = [](double missed, long long components_and_handles) {
        RunScore score = with_contours(missed, components_and_handles);
        score.deviates = true;
        return score;
    };
    EXPECT_TRUE(is_worse(deviates(0.2, 4), deviates(0.1, 4)));
    EXPECT_TRUE(is_worse(deviates(0.1, 14), deviates(0.1, 8)));
    EXPECT_FALSE(is_worse(deviates(0.05, 14), deviates(0.1, 8)));
    EXPECT_FALSE(is_worse(deviates(0.1, 8), deviates(0.1, 14)));
    EXPECT_TRUE(is_worse(deviates(0.05, 4), with_contours(0.2, 4))) << "one that is not astray comes first";
    RunScore far = deviates(0.05, 4);
    far.farthest = 0.8;
    EXPECT_TRUE(is_worse(far, deviates(0.2, 8))) << "a spike that a warning tells of";
    EXPECT_FALSE(is_worse(deviates(0.2, 8), far));
    EXPECT_FALSE(is_worse(far, far));
}

TEST(RetryPolicy, OneThatMeetsAllClausesComesBeforeOneThatDoesNot) {
    const RunScore lacking = [] {
        RunScore score = with_contours(0, 4, 2e-4, 0.2);
        score.unmet_clauses = 1;
        return score;
    }();
    RunScore whole = with_contours(0.01, 4, 0, 0.5);
    whole.deviates = true;
    EXPECT_FALSE(is_worse(whole, lacking));
    EXPECT_TRUE(is_worse(lacking, whole));
    whole.farthest = 0.51;
    EXPECT_TRUE(is_worse(whole, lacking)) << "a spike that a warning tells of";
}

}  // namespace
}  // namespace anatomesh::retry_policy_test
