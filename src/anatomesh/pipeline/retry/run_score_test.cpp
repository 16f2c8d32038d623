#include "anatomesh/pipeline/retry/run_score.h"

#include <gtest/gtest.h>

#include <string>

namespace anatomesh::run_score_test {
namespace {

// A model that keeps the contract: two structures of 100 segments each, 4 of which are no chains of edges.
ModelReport report_of_two() {
    ModelReport report;
    report.quality.radius_edge_share_over_2 = 0.25;
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
    RunScore score = score_of(Model{}, report, facts_of_two());
    EXPECT_TRUE(score.kept_contract);
    EXPECT_EQ(score.over_bound, 0.25);
    EXPECT_EQ(score.unmet_clauses, 0u);
    EXPECT_FALSE(score.lacks_contours);
    EXPECT_EQ(score.components_and_handles, 5);
    EXPECT_EQ(score.unforced, 0.02);
    EXPECT_EQ(score.bad, 0.005);
    EXPECT_EQ(score.missed, 0.02);
    EXPECT_EQ(score.farthest, 0.5);
    for (const int number : {2, 4}) {
        report.certificate[1] = {number, ClauseState::not_promised_yet, "", ""};
        score = score_of(Model{}, report, facts_of_two());
        EXPECT_EQ(score.unmet_clauses, 1u);
        EXPECT_EQ(score.lacks_contours, number == 2);
    }
    report.field.distance.at_least = true;
    EXPECT_GT(score_of(Model{}, report, facts_of_two()).farthest, 1e9) << "it is not known how far";
}

TEST(RunScore, SegmentsWithEdgesBesideThemCountAsMissed) {
    ModelReport report = report_of_two();
    RunFacts facts = facts_of_two();
    facts.segments_missed = 10;
    RunScore score = score_of(Model{}, report, facts);
    EXPECT_EQ(score.missed, 0.05) << "of these some were led along the surface";
    EXPECT_FALSE(score.lacks_contours);
    facts.has_segments_beside = true;
    score = score_of(Model{}, report, facts);
    EXPECT_TRUE(score.lacks_contours);
    EXPECT_EQ(score.unmet_clauses, 1u);
    report.certificate[1].state = ClauseState::not_promised_yet;
    EXPECT_EQ(score_of(Model{}, report, facts).unmet_clauses, 1u) << "one clause, for two reasons";
}

TEST(RunScore, WhatConformedIsBadWithSingleCellsOrASurfaceAstray) {
    ModelReport report = report_of_two();
    report.listed_cells.bad = 0;
    RunFacts facts = facts_of_two();
    EXPECT_FALSE(score_of(Model{}, report, facts).conformed_badly);
    facts.conformed = true;
    EXPECT_FALSE(score_of(Model{}, report, facts).conformed_badly);
    facts.deviates = true;
    EXPECT_TRUE(score_of(Model{}, report, facts).conformed_badly);
    facts.deviates = false;
    report.listed_cells.bad = 1;
    EXPECT_TRUE(score_of(Model{}, report, facts).conformed_badly);
    facts.conformed = false;
    EXPECT_FALSE(score_of(Model{}, report, facts).conformed_badly);
}

TEST(RunScore, OfOneThatIsRefusedItIsToldWhetherASizeMayMend) {
    for (const char* code : {"E-PIP-002", "E-CUT-001", "E-PIP-001"}) {
        const Result<Model> refused = Error{ErrorKind::geometry, code, "", {}, ""};
        const RunScore score = score_of(refused, report_of_two(), facts_of_two());
        EXPECT_FALSE(score.kept_contract);
        EXPECT_EQ(score.size_matters, std::string(code) != "E-PIP-001") << code;
        EXPECT_EQ(score.cells, 1000u);
        EXPECT_EQ(score.unforced, 0.02) << "as far as it came";
        EXPECT_EQ(score.unmet_clauses, 0u) << "its certificate was not judged";
    }
}

}  // namespace
}  // namespace anatomesh::run_score_test
