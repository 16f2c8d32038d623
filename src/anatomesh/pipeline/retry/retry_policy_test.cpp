#include "anatomesh/pipeline/retry/retry_policy.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <string>
#include <vector>

namespace anatomesh::retry_policy_test {
namespace {

const RunOutcome good{{.kept_contract = true, .over_bound = 0.001}, {.cells = 100000}};
const RunOutcome broken{{}, {.size_matters = true}};
const RunOutcome broken_spared{{}, {.size_matters = true, .can_do_more = true}};
const RunOutcome ill_shaped{{.kept_contract = true, .over_bound = 0.0055}, {.cells = 100000}};
const RunOutcome torn{{.kept_contract = true, .torn = true, .over_bound = 0.001}, {.cells = 100000}};
// Contour segments were split for each other's sake.
const RunOutcome broken_conformed{
    {}, {.size_matters = true, .can_do_more = true, .conformed = true, .cells = 50000}};
const RunOutcome bad_conformed{{.kept_contract = true, .over_bound = 0.001, .bad = 1e-3},
                               {.can_do_more = true, .conformed = true, .cells = 50000}};

RunOutcome with_cells(RunOutcome outcome, std::size_t cells) {
    outcome.course.cells = cells;
    return outcome;
}

// The best so far is the last run, if that keeps the contract.
NextRun next_after(RetryPolicy& policy, const RunOutcome& last) {
    return policy.next(last, last.score.kept_contract ? &last : nullptr);
}

// Tries as often as it is told to, always with that outcome.
std::vector<NextRun> all_runs(const RunOutcome& always, bool size_given) {
    RetryPolicy policy(size_given);
    std::vector<NextRun> runs;
    do runs.push_back(next_after(policy, always));
    while (runs.back() != NextRun::none && runs.size() < 100);
    return runs;
}

TEST(RetryPolicy, AGoodModelIsTheLast) {
    for (const bool given : {false, true}) EXPECT_EQ(all_runs(good, given), std::vector{NextRun::none});
}

TEST(RetryPolicy, OfEveryOutcomeTheTriesEnd) {
    for (unsigned bits = 0; bits < 256; ++bits) {
        const RunOutcome outcome{{.kept_contract = (bits & 1) != 0,
                                  .torn = (bits & 8) != 0,
                                  .over_bound = bits & 16 ? 0.5 : 0.0,
                                  .bad = bits & 64 ? 0.1 : 0.0},
                                 {.size_matters = (bits & 2) != 0,
                                  .can_do_more = (bits & 4) != 0,
                                  .conformed = (bits & 128) != 0,
                                  .cells = bits & 32 ? RetryPolicy::again_below : std::size_t{10}}};
        for (const bool given : {false, true}) {
            const std::vector<NextRun> runs = all_runs(outcome, given);
            EXPECT_LE(runs.size(),
                      RetryPolicy::most_finer + RetryPolicy::most_same + RetryPolicy::most_slightly_finer + 1)
                << bits;
            if (!given) continue;
            for (const NextRun next : runs)
                EXPECT_TRUE(next == NextRun::none || next == NextRun::same_size) << bits;
        }
    }
}

// Every row of the table but the last decides in a case of its own: none is dead.
TEST(RetryPolicy, EachRuleOfTheTableDecidesSomewhere) {
    const std::vector<RetrySituation> situations{
        {.refused = true, .best_split_segments = true},
        {},
        {.refused = true, .may_finer = true, .was_finer_for_shape = true},
        {.refused = true,
         .conformed = true,
         .can_do_more = true,
         .few_unforced = true,
         .may_slightly_finer = true},
        {.conformed = true, .conformed_badly = true, .can_do_more = true, .best_hardly_bad = true},
        {.met_limit = true, .conformed = true},
        {.refused = true, .can_do_more = true, .may_same = true},
        {.torn = true, .may_finer = true},
        {.torn = true},
    };
    const std::span<const RetryRule> rules = RetryPolicy::rules();
    ASSERT_EQ(rules.size(), situations.size());
    std::set<std::string> reasons;
    for (std::size_t row = 0; row < rules.size(); ++row) {
        std::size_t first = 0;
        while (!rules[first].applies(situations[row])) ++first;
        EXPECT_EQ(first, row) << rules[first].when;
        reasons.insert(rules[row].when);
    }
    EXPECT_EQ(reasons.size(), rules.size());
}

TEST(RetryPolicy, WhatIsBadAfterSplittingIsCellsOrBumps) {
    EXPECT_TRUE(conformed_badly(bad_conformed));
    RunOutcome bumpy = bad_conformed;
    bumpy.score.bad = 0;
    EXPECT_FALSE(conformed_badly(bumpy));
    bumpy.score.deviates = true;
    EXPECT_TRUE(conformed_badly(bumpy));
    bumpy.course.conformed = false;
    EXPECT_FALSE(conformed_badly(bumpy));
}

// A few ill-shaped cells in tens of thousands are luck: another edge length has others.
TEST(RetryPolicy, WhatConformedBadlyIsTriedSlightlyFinerAndOnlyThenWithoutThat) {
    for (const RunOutcome& bad : {broken_conformed, bad_conformed}) {
        RetryPolicy policy(false);
        for (std::size_t n = 1; n <= RetryPolicy::most_slightly_finer; ++n) {
            EXPECT_EQ(next_after(policy, bad), NextRun::slightly_finer);
            EXPECT_EQ(policy.slightly_finer(), n);
        }
        EXPECT_EQ(next_after(policy, bad), NextRun::same_size);
        EXPECT_EQ(next_after(policy, broken), NextRun::finer);
        RetryPolicy lucky(false);
        EXPECT_EQ(next_after(lucky, bad), NextRun::slightly_finer);
        EXPECT_EQ(next_after(lucky, good), NextRun::none);
    }
}

// A limit that shorter edges meet is none of the model with the edges before.
TEST(RetryPolicy, WhereASlightlyFinerOneStopsItIsBuiltWithoutThat) {
    const RunOutcome stopped{{}, {.conformed = true}};
    RetryPolicy policy(false);
    EXPECT_EQ(next_after(policy, broken_conformed), NextRun::slightly_finer);
    EXPECT_EQ(next_after(policy, stopped), NextRun::same_size);
    RetryPolicy other(false);
    EXPECT_EQ(next_after(other, stopped), NextRun::none);
}

TEST(RetryPolicy, WhatConformedBadlyAndIsLargeOrOfAGivenSizeIsBuiltWithoutThatAtOnce) {
    for (const RunOutcome& bad : {broken_conformed, bad_conformed}) {
        RetryPolicy given(true), large(false), unlucky(false);
        EXPECT_EQ(next_after(given, bad), NextRun::same_size);
        EXPECT_EQ(next_after(large, with_cells(bad, RetryPolicy::slightly_finer_below)), NextRun::same_size);
        RunOutcome full = bad;
        full.course.unforced = 0.011;
        EXPECT_EQ(next_after(unlucky, full), NextRun::same_size);
    }
}

TEST(RetryPolicy, AllTheWorkIsDoneBeforeFinerCells) {
    RetryPolicy policy(false);
    EXPECT_EQ(next_after(policy, broken_spared), NextRun::same_size);
    EXPECT_EQ(next_after(policy, broken), NextRun::finer);
    EXPECT_EQ(next_after(policy, good), NextRun::none);
}

TEST(RetryPolicy, WhatNoSizeMendsIsNotTriedAgain) {
    RunOutcome wrong = broken;
    wrong.course.size_matters = false;
    EXPECT_EQ(all_runs(wrong, false), std::vector{NextRun::none});
}

// Two contours a hundredth of an edge from each other: any size has ill-shaped cells there.
TEST(RetryPolicy, ForTheShapesOnlyOneTryIsFiner) {
    EXPECT_EQ(all_runs(ill_shaped, false), (std::vector{NextRun::finer, NextRun::none}));
    EXPECT_EQ(all_runs(ill_shaped, true), std::vector{NextRun::none});
    EXPECT_EQ(all_runs(with_cells(ill_shaped, RetryPolicy::again_below), false), std::vector{NextRun::none});
    RetryPolicy policy(false);
    EXPECT_EQ(next_after(policy, ill_shaped), NextRun::finer);
    EXPECT_EQ(policy.next(broken, &ill_shaped), NextRun::none) << "the coarser one kept the contract";
}

TEST(RetryPolicy, TornWallsAreTriedFinerWhileTheyAreTorn) {
    EXPECT_EQ(all_runs(torn, false),
              (std::vector{NextRun::finer, NextRun::finer, NextRun::finer, NextRun::none}));
    EXPECT_EQ(all_runs(torn, true), std::vector{NextRun::none});
}

TEST(RetryPolicy, WhereTheBestModelSplitSegmentsNoFinerOneIsTriedWithoutThat) {
    RunOutcome other = ill_shaped;
    other.score.missed = 0.2;
    RetryPolicy alone(false);
    EXPECT_EQ(next_after(alone, other), NextRun::finer);
    RunOutcome best = bad_conformed;
    best.score.missed = 0.1;
    RetryPolicy policy(false);
    EXPECT_EQ(policy.next(other, &best), NextRun::none);
    EXPECT_EQ(policy.next(broken, &best), NextRun::finer) << "no model to take it for";
}

TEST(RetryPolicy, WhatIsHardlyBadIsNotTriedWithoutItsContours) {
    for (const bool deviates : {false, true}) {
        const auto after = [&](auto change) {
            RunOutcome best = with_cells(bad_conformed, RetryPolicy::slightly_finer_below);
            best.score.bad = 1e-4;
            best.score.deviates = deviates;
            best.score.farthest = 0.5;
            change(best.score);
            RetryPolicy policy(false);
            return next_after(policy, best);
        };
        EXPECT_EQ(after([](RunScore&) {}), NextRun::none);
        EXPECT_EQ(after([](RunScore& score) { score.bad = 2e-4; }), NextRun::same_size);
        EXPECT_EQ(after([](RunScore& score) { score.torn = true; }), NextRun::same_size);
        EXPECT_EQ(after([](RunScore& score) { score.farthest = 0.51; }),
                  deviates ? NextRun::same_size : NextRun::none)
            << "a spike that a warning tells of";
    }
}

TEST(RetryPolicy, ASmallModelThatDoesNotMeetAllClausesMayDoSoWithShorterEdges) {
    EXPECT_FALSE(may_meet_all_clauses(with_cells(good, 50000), 1)) << "it meets all";
    RunOutcome lacking = with_cells(good, 50000);
    lacking.score.unmet_clauses = 1;
    for (const std::size_t runs : {1, 3, 6}) EXPECT_TRUE(may_meet_all_clauses(lacking, runs));
    EXPECT_FALSE(may_meet_all_clauses(lacking, 7)) << "its tries are no luck";
    EXPECT_FALSE(may_meet_all_clauses(with_cells(lacking, 100000), 1)) << "its tries take long";
    lacking.course.contradicted = true;
    EXPECT_FALSE(may_meet_all_clauses(lacking, 1)) << "no model has all";
    lacking.course.contradicted = false;
    lacking.score.kept_contract = false;
    EXPECT_FALSE(may_meet_all_clauses(lacking, 1));
}

TEST(RetryPolicy, AModelOfWhichContoursDoNotTellAllIsTangled) {
    EXPECT_FALSE(is_tangled(good));
    RunOutcome tangled = with_cells(good, 50000);
    tangled.score.spurious_joints = 1;
    EXPECT_TRUE(is_tangled(tangled));
    EXPECT_FALSE(is_tangled(with_cells(tangled, 100000))) << "its tries take long";
    tangled.score.kept_contract = false;
    EXPECT_FALSE(is_tangled(tangled));
}

}  // namespace
}  // namespace anatomesh::retry_policy_test
