#include "anatomesh/pipeline/retry/compare_reports.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace anatomesh::compare_reports_test {
namespace {

struct Case {
    ModelReport report;
    std::vector<Warning> warnings;
};

Case middling() {
    Case model;
    ModelReport& report = model.report;
    report.counts.tetrahedra = 10000;
    for (int number = 1; number <= 6; ++number)
        report.certificate.push_back({number, ClauseState::not_promised_yet, "", ""});
    StructureReport structure;
    structure.surface.components = 2;
    structure.pieces = 2;
    structure.surface.genus = 1;
    structure.fidelity.vertices_on_surface = 100;
    structure.fidelity.segments_on_surface = 90;
    structure.shells.without_contour = 1;
    structure.shells.parts_too_many = 1;
    report.structures = {structure};
    report.contours.sections = {{"one", "k = 1", 100, 0.5, 0}, {"one", "k = 2", 100, 0.05, 0}};
    report.field.distance.max_mm = 0.6;
    report.field.distance.joined_mm = 0.6;
    report.field.difference.max_mm = 0.6;
    report.quality.radius_edge.mean = 0.96;
    report.quality.radius_edge.share_over_2 = 0.001;
    report.quality.radius_edge.max = 3;
    report.quality.dihedral_deg.min = 9;
    report.quality.dihedral_deg.below_10 = 2;
    report.listed_cells.total = 8;
    report.listed_cells.forced = 1;
    model.warnings = {{"W-PIP-004", "", {}, ""}};
    return model;
}

bool no_worse(const Case& model, const Case& other) {
    return is_no_worse({model.report, model.warnings}, {other.report, other.warnings},
                       {0.5, 1, 0.0005, 2, 2});
}

TEST(CompareReports, EqualModelsAreNoWorse) {
    EXPECT_TRUE(no_worse(middling(), middling()));
}

// Each figure alone turns the scale, one way only.
TEST(CompareReports, OneWorseFigureIsEnough) {
    const std::vector<std::pair<std::string, std::function<void(Case&)>>> worse{
        {"cells", [](Case& m) { m.report.counts.tetrahedra = 20001; }},
        {"clause", [](Case& m) { m.report.certificate[3].state = ClauseState::broken; }},
        {"vertices", [](Case& m) { m.report.structures[0].fidelity.vertices_on_surface = 99; }},
        {"segments", [](Case& m) { m.report.structures[0].fidelity.segments_on_surface = 89; }},
        {"shells", [](Case& m) { m.report.structures[0].shells.without_contour = 2; }},
        {"parts", [](Case& m) { m.report.structures[0].shells.parts_too_many = 2; }},
        {"cuts", [](Case& m) { m.report.contours.sections[1].difference_mm2 = 0.2; }},
        {"worst cut", [](Case& m) { m.report.contours.sections[0].difference_mm2 = 0.6; }},
        {"distance", [](Case& m) { m.report.field.distance.max_mm = 0.7; }},
        {"unknown distance", [](Case& m) { m.report.field.distance.at_least = true; }},
        {"joint", [](Case& m) { m.report.field.distance.joined_mm = 0.7; }},
        {"difference", [](Case& m) { m.report.field.difference.max_mm = 0.7; }},
        {"mean", [](Case& m) { m.report.quality.radius_edge.mean = 0.97; }},
        {"share", [](Case& m) { m.report.quality.radius_edge.share_over_2 = 0.002; }},
        {"largest ratio", [](Case& m) { m.report.quality.radius_edge.max = 3.1; }},
        {"angles", [](Case& m) { m.report.quality.dihedral_deg.below_10 = 3; }},
        {"least angle", [](Case& m) { m.report.quality.dihedral_deg.min = 8; }},
        {"no reason", [](Case& m) { m.report.listed_cells.forced = 0; }},
        {"warning", [](Case& m) { m.warnings.push_back(m.warnings.front()); }},
        {"other warning", [](Case& m) { m.warnings.front().code = "W-PIP-008"; }},
    };
    for (const auto& [figure, spoil] : worse) {
        SCOPED_TRACE(figure);
        Case spoilt = middling();
        spoil(spoilt);
        EXPECT_FALSE(no_worse(spoilt, middling()));
        EXPECT_EQ(no_worse(middling(), spoilt), figure != "other warning");
    }
}

// Neither is right in itself.
TEST(CompareReports, AnotherSurfaceIsWorseBothWays) {
    const std::vector<std::function<void(StructureReport&)>> changes{
        [](StructureReport& s) { s.surface.components = 3; }, [](StructureReport& s) { s.pieces = 1; },
        [](StructureReport& s) { s.surface.genus = 0; }, [](StructureReport& s) { s.shells.voids = 1; }};
    for (const auto& change : changes) {
        Case other = middling();
        change(other.report.structures[0]);
        EXPECT_FALSE(no_worse(other, middling()));
        EXPECT_FALSE(no_worse(middling(), other));
    }
}

TEST(CompareReports, SingleCellsAboveTheBoundAreAllowed) {
    Case few = middling(), none = middling();
    few.report.listed_cells.total = 7;
    few.report.quality.radius_edge.share_over_2 = 0.0005;
    few.report.quality.radius_edge.max = 3.9;
    none.report.listed_cells.total = 1;
    none.report.quality.radius_edge.share_over_2 = 0;
    none.report.quality.radius_edge.max = 1.9;
    const auto compare = [&](const CompareOptions& options) {
        return is_no_worse({few.report, few.warnings}, {none.report, none.warnings}, options);
    };
    EXPECT_FALSE(compare({0.5, 1, 0.0005, 3.9, 2})) << "6 without a reason, of 10000";
    few.report.listed_cells.forced = 2;
    EXPECT_TRUE(compare({0.5, 1, 0.0005, 3.9, 2}));
    EXPECT_FALSE(compare({0.5, 1, 0.0004, 3.9, 2}));
    EXPECT_FALSE(compare({0.5, 1, 0.0005, 3.8, 2}));
}

TEST(CompareReports, WithinWhatIsNearEnoughDistancesAreAlike) {
    Case near = middling(), nearer = middling();
    near.report.field.distance.max_mm = 0.49;
    nearer.report.field.distance.max_mm = 0.1;
    EXPECT_TRUE(no_worse(near, nearer));
}

}  // namespace
}  // namespace anatomesh::compare_reports_test
