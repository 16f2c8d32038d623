#include "anatomesh/pipeline/retry/run_score.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace anatomesh::run_score_test {
namespace {

// A model that keeps the contract: two structures of 100 segments each, 4 of which are no chains of edges.
ModelReport report_of_two() {
    ModelReport report;
    report.quality.radius_edge.share_over_2 = 0.25;
    report.certificate = {{1, ClauseState::kept, "", ""}, {2, ClauseState::kept, "", ""}};
    report.structures.resize(2);
    for (StructureReport& structure : report.structures) {
        structure.fidelity.segments = 100;
        structure.fidelity.segments_on_surface = 98;
        structure.surface.components = 1;
    }
    report.structures[1].surface.genus = 3;
    report.listed_cells.total = 30;
    report.listed_cells.forced = 10;
    report.listed_cells.bad = 5;
    report.field.distance.max_mm = 1.5;
    return report;
}

RunFacts facts_of_two() {
    RunFacts facts;
    facts.size_mm = 3;
    facts.cells = 1000;
    facts.drawn_segments = 200;
    return facts;
}

TEST(RunScore, AReportTellsOfAModelThatKeepsTheContract) {
    ModelReport report = report_of_two();
    const RunOutcome outcome = outcome_of(Model{}, report, facts_of_two());
    const RunScore& score = outcome.score;
    EXPECT_TRUE(score.kept_contract);
    EXPECT_EQ(score.over_bound, 0.25);
    EXPECT_EQ(score.unmet_clauses, 0u);
    EXPECT_EQ(score.components_and_handles, 5);
    EXPECT_EQ(outcome.course.unforced, 0.02);
    EXPECT_EQ(score.bad, 0.005);
    EXPECT_EQ(score.missed, 0.02);
    EXPECT_EQ(score.farthest, 0.5);
    for (const int number : {2, 4}) {
        report.certificate[1] = {number, ClauseState::not_promised_yet, "", ""};
        EXPECT_EQ(outcome_of(Model{}, report, facts_of_two()).score.unmet_clauses, 1u);
    }
    report.field.distance.at_least = true;
    EXPECT_GT(outcome_of(Model{}, report, facts_of_two()).score.farthest, 1e9) << "it is not known how far";
}

TEST(RunScore, SegmentsWithEdgesBesideThemCountAsMissed) {
    ModelReport report = report_of_two();
    RunFacts facts = facts_of_two();
    facts.segments_missed = 10;
    RunScore score = outcome_of(Model{}, report, facts).score;
    EXPECT_EQ(score.missed, 0.05) << "of these some were led along the surface";
    EXPECT_EQ(score.unmet_clauses, 0u);
    facts.has_segments_beside = true;
    EXPECT_EQ(outcome_of(Model{}, report, facts).score.unmet_clauses, 1u);
    report.certificate[1].state = ClauseState::not_promised_yet;
    EXPECT_EQ(outcome_of(Model{}, report, facts).score.unmet_clauses, 1u) << "one clause, for two reasons";
}

TEST(RunScore, OfOneThatIsRefusedItIsToldWhetherASizeMayMend) {
    for (const char* code : {"E-PIP-002", "E-CUT-001", "E-PIP-001"}) {
        const Result<Model> refused = Error{ErrorKind::geometry, code, "", {}, ""};
        const RunOutcome outcome = outcome_of(refused, report_of_two(), facts_of_two());
        EXPECT_FALSE(outcome.score.kept_contract);
        EXPECT_EQ(outcome.course.size_matters, std::string(code) != "E-PIP-001") << code;
        EXPECT_EQ(outcome.course.cells, 1000u);
        EXPECT_EQ(outcome.course.unforced, 0.02) << "as far as it came";
        EXPECT_EQ(outcome.score.unmet_clauses, 0u) << "its certificate was not judged";
    }
}

// Each pair differs in one criterion and, the other way round, in all that come after it.
TEST(RunScore, TheFirstCriterionThatDiffersDecides) {
    // One clause is not met, so that no result is whole: that criterion has a test of its own.
    const RunScore good{.kept_contract = true, .unmet_clauses = 1};
    const auto with = [](RunScore score, auto change) {
        change(score);
        return score;
    };
    using Change = void (*)(RunScore&);
    const std::vector<Change> worsened{
        [](RunScore& score) { score.kept_contract = false; },
        [](RunScore& score) { score.torn = true; },
        [](RunScore& score) { score.farthest = 0.76; },
        [](RunScore& score) { score.bad = 1.1e-3; },
        [](RunScore& score) { score.missed = 0.0051; },
        [](RunScore& score) { score.unmet_clauses = 2; },
        [](RunScore& score) { score.spurious_joints = 1; },
        [](RunScore& score) { score.deviates = true; },
        [](RunScore& score) { score.bad = std::max(score.bad, 1e-9); },
        [](RunScore& score) { score.components_and_handles = 1; },
        [](RunScore& score) { score.over_bound = 0.0051; },
    };
    RunScore later_ones = good;
    for (std::size_t n = worsened.size(); n-- > 0;) {
        const RunScore worse = with(good, worsened[n]);
        EXPECT_TRUE(is_better(later_ones, worse)) << "criterion " << n + 1;
        EXPECT_FALSE(is_better(worse, later_ones)) << "criterion " << n + 1;
        worsened[n](later_ones);
    }
}

TEST(RunScore, AWholeResultComesBeforeOneThatMissesFewerSegments) {
    const RunScore whole{.kept_contract = true, .missed = 0.05, .farthest = 0.5, .bad = 1e-4};
    const RunScore lacking{.kept_contract = true, .missed = 0.01, .unmet_clauses = 1};
    EXPECT_TRUE(is_better(whole, lacking));
    EXPECT_FALSE(is_better(lacking, whole));
    using Change = void (*)(RunScore&);
    for (const Change change : std::vector<Change>{
             [](RunScore& score) { score.missed = 0.051; }, [](RunScore& score) { score.unmet_clauses = 1; },
             [](RunScore& score) { score.spurious_joints = 1; }, [](RunScore& score) { score.bad = 2e-4; },
             [](RunScore& score) { score.farthest = 0.51; }}) {
        RunScore not_whole = whole;
        change(not_whole);
        EXPECT_TRUE(is_better(lacking, not_whole)) << "then segments decide";
    }
}

TEST(RunScore, SmallDifferencesCountAsNone) {
    const auto equal = [](const RunScore& one, const RunScore& other) {
        return !is_better(one, other) && !is_better(other, one);
    };
    EXPECT_TRUE(equal({.missed = 0}, {.missed = 0.005}));
    EXPECT_TRUE(is_better({.missed = 0.1}, {.missed = 0.1 * 4 / 3 + 1e-9}));
    EXPECT_TRUE(equal({.bad = 2e-4}, {.bad = 9e-4}));
    EXPECT_TRUE(is_better({.bad = 1e-4}, {.bad = 2e-4}));
    EXPECT_TRUE(equal({.farthest = 0.1}, {.farthest = 0.5}));
    EXPECT_TRUE(equal({.over_bound = 0}, {.over_bound = 0.005}));
    EXPECT_FALSE(is_better({.farthest = std::numeric_limits<double>::infinity()}, {})) << "it is not known";
}

// So that "A over B over C over A" cannot be.
TEST(RunScore, TheOrderIsAStrictWeakOne) {
    std::mt19937 random(1);
    const auto pick = [&](auto... values) {
        const std::array all{values...};
        return all[random() % all.size()];
    };
    std::vector<RunScore> scores(60);
    for (RunScore& score : scores) {
        score.kept_contract = random() % 8 > 0;
        score.torn = random() % 4 == 0;
        score.deviates = random() % 4 == 0;
        score.missed = pick(0.0, 0.004, 0.006, 0.05, 0.06, 0.07, 0.2, 1.0);
        score.components_and_handles = pick(1LL, 2LL, -1LL);
        score.spurious_joints = random() % 3;
        score.unmet_clauses = random() % 3;
        score.farthest = pick(0.2, 0.5, 0.6, 0.75, 2.0);
        score.over_bound = pick(0.0, 0.005, 0.006, 0.0064, 0.5);
        score.bad = pick(0.0, 1e-5, 1e-4, 2e-4, 1e-3, 2e-3);
    }
    const auto same = [](const RunScore& one, const RunScore& other) {
        return !is_better(one, other) && !is_better(other, one);
    };
    std::size_t ordered = 0;
    for (const RunScore& a : scores) {
        EXPECT_FALSE(is_better(a, a));
        for (const RunScore& b : scores) {
            ordered += is_better(a, b);
            EXPECT_FALSE(is_better(a, b) && is_better(b, a));
            for (const RunScore& c : scores) {
                EXPECT_TRUE(!(is_better(a, b) && is_better(b, c)) || is_better(a, c));
                EXPECT_TRUE(!(same(a, b) && same(b, c)) || same(a, c));
            }
        }
    }
    EXPECT_GT(ordered, 1500u) << "most pairs differ";
}

}  // namespace
}  // namespace anatomesh::run_score_test
