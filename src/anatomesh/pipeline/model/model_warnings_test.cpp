#include "anatomesh/pipeline/model/model_warnings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace anatomesh::model_warnings_test {
namespace {

std::size_t warnings_of_distance(double max_mm, bool at_least, std::uint64_t points = 10) {
    ModelReport report;
    report.field.distance.points = points;
    report.field.distance.max_mm = max_mm;
    report.field.distance.at_least = at_least;
    RunContext context;
    warn_of_model(report, 2.0, "drawn.json", context);
    std::size_t count = 0;
    for (const Warning& warning : context.warnings) count += warning.code == "W-PIP-008";
    return count;
}

TEST(ModelWarnings, a_surface_far_from_the_field) {
    EXPECT_EQ(warnings_of_distance(1.1, false), 1u);
    EXPECT_EQ(warnings_of_distance(0.9, false), 0u);
    // The field tells no more than this: it may be any distance.
    EXPECT_EQ(warnings_of_distance(0.5, true), 1u);
    EXPECT_EQ(warnings_of_distance(3, true, 0), 0u);  // not measured
}

TEST(ModelWarnings, cells_that_contours_force_to_be_flat) {
    ModelReport report;
    report.listed_cells.cells = {{5, 1e6, 0.3, {1, 2, 3}, "contour vertices 1 and 2 0.000 mm apart"},
                                 {7, 90, 0.06, {1, 2, 3}, "contour vertices 3 and 4 0.01 mm apart"},
                                 {8, 3, 0.01, {4, 5, 6}, "contour vertices 5 and 6 0.000 mm apart"}};
    RunContext context;
    warn_of_model(report, 4, "file", context);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-PIP-014");
    EXPECT_EQ(context.warnings[0].message.substr(0, 17), "2 tetrahedra have");
    EXPECT_EQ(context.warnings[0].place.value, "0.01 degrees at 4 5 6");
    report.listed_cells.cells.erase(report.listed_cells.cells.begin());
    report.listed_cells.cells.pop_back();
    RunContext sound;
    warn_of_model(report, 4, "file", sound);
    EXPECT_TRUE(sound.warnings.empty());
}

TEST(ModelWarnings, segments_that_are_missed) {
    const auto warned = [](const std::vector<std::uint64_t>& missed, std::uint64_t contradicted = 0) {
        ModelReport report;
        for (const std::uint64_t count : missed) {
            report.structures.emplace_back();
            report.structures.back().number = static_cast<std::int32_t>(report.structures.size());
            report.structures.back().fidelity.segments = 100;
            report.structures.back().fidelity.segments_on_surface = 100 - count;
            report.structures.back().fidelity.segments_contradicted = contradicted;
        }
        RunContext context;
        warn_of_model(report, 2.0, "drawn.json", context);
        return context.warnings;
    };
    EXPECT_TRUE(warned({0, 0}).empty());
    const std::vector<Warning> alone = warned({3});
    ASSERT_EQ(alone.size(), 1u);
    EXPECT_EQ(alone[0].what_was_done.find("--close-gaps"), std::string::npos);  // nothing is drawn beside it
    EXPECT_EQ(alone[0].message.find("contradicts them"), std::string::npos) << alone[0].message;
    EXPECT_NE(
        warned({3}, 2)[0].message.find("2 of them cross another slice where that slice contradicts them"),
        std::string::npos)
        << warned({3}, 2)[0].message;
    const std::vector<Warning> warnings = warned({1, 4, 2});
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0].code, "W-PIP-012");
    EXPECT_EQ(warnings[0].place.structure, "2");
    EXPECT_EQ(warnings[0].place.value, "4 segments");
    EXPECT_NE(warnings[0].message.find("7 of 300"), std::string::npos) << warnings[0].message;
    EXPECT_NE(warnings[0].what_was_done.find("--close-gaps"), std::string::npos);
}

TEST(ModelWarnings, surfaces_that_meet_and_should_not) {
    for (const auto& [joined_mm, expected] : {std::pair{1.1, 1}, {0.9, 0}}) {
        ModelReport report;
        report.field.distance.points = 10;
        report.field.distance.joined_mm = joined_mm;
        RunContext context;
        warn_of_model(report, 2.0, "drawn.json", context);
        EXPECT_EQ(std::count_if(context.warnings.begin(), context.warnings.end(),
                                [](const Warning& warning) { return warning.code == "W-PIP-009"; }),
                  expected);
    }
}

TEST(ModelWarnings, a_part_that_is_missing_and_one_too_many) {
    for (const bool missing : {true, false}) {
        for (const auto& [max_mm, points, expected] :
             {std::tuple{1.1, 10, true}, {0.9, 10, false}, {1.1, 0, false}}) {
            ModelReport report;
            report.field.difference.points = static_cast<std::uint64_t>(points);
            report.field.difference.max_mm = max_mm;
            report.field.difference.missing = missing;
            RunContext context;
            warn_of_model(report, 2.0, "drawn.json", context);
            ASSERT_EQ(context.warnings.size(), expected ? 1u : 0u);
            if (!expected) continue;
            EXPECT_EQ(context.warnings[0].code, "W-PIP-010");
            EXPECT_EQ(context.warnings[0].message.find("is missing in the model") != std::string::npos,
                      missing);
        }
    }
}

TEST(ModelWarnings, a_volume_between_slices_that_is_not_what_is_drawn) {
    const std::vector<Structure> structures{
        {3, "organ", {1, 2, 3}}, {7, "", {4, 5, 6}}, {9, "free", {7, 8, 9}}};
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    const std::vector<StructureVolume> good{{1049, 1000}, {96, 100}, {50, unknown}};
    const std::vector<StructureVolume> bad{{1051, 1000}, {94, 100}, {50, unknown}};
    RunContext context;
    warn_of_volumes(good, structures, true, "drawn.json", context);
    EXPECT_TRUE(context.warnings.empty());
    warn_of_volumes(bad, structures, true, "drawn.json", context);
    ASSERT_EQ(context.warnings.size(), 2u);
    EXPECT_EQ(context.warnings[0].code, "W-PIP-011");
    EXPECT_EQ(context.warnings[0].place.structure, "organ");
    EXPECT_EQ(context.warnings[1].place.structure, "7");
    EXPECT_EQ(context.warnings[1].place.value, "94 of 100 mm3");
}

TEST(ModelWarnings, a_structure_alone_may_taper_but_not_have_necks) {
    const std::vector<Structure> structures{{1, "cone", {1, 2, 3}}, {2, "vessel", {4, 5, 6}}};
    RunContext context;
    warn_of_volumes(std::vector<StructureVolume>{{90, 100, 0}, {90, 100, -4.9}}, structures, false,
                    "drawn.json", context);
    EXPECT_TRUE(context.warnings.empty());
    warn_of_volumes(std::vector<StructureVolume>{{90, 100, 0}, {90, 100, -5.1}}, structures, false,
                    "drawn.json", context);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-PIP-011");
    EXPECT_EQ(context.warnings[0].place.structure, "vessel");
    EXPECT_EQ(context.warnings[0].place.value, "90 of 100 mm3");
}

// Single tetrahedra in a row, each of a region.
TEST(ModelWarnings, C11_structures_that_overlap_are_told_with_the_volume_of_both) {
    TetMesh mesh;
    const auto add = [&](double x, double size, Region region) {
        const auto first = static_cast<std::uint32_t>(mesh.points.size());
        for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{size, 0, 0}, Vec3{0, size, 0}, Vec3{0, 0, size}})
            mesh.points.push_back(Vec3{x, 0, 0} + p);
        mesh.cells.push_back({first, first + 1, first + 2, first + 3});
        mesh.regions.push_back(region);
    };
    const std::vector<Structure> structures{{1, "liver", {}}, {2, "", {}}, {3, "rib", {}}};
    RegionTable regions{{{}, {0}, {0, 1}, {1}, {2}, {0, 2}}};
    add(0, 2, 1);
    add(3, 1, 3);
    add(6, 1, 4);
    RunContext apart;
    warn_of_overlaps(mesh, regions, structures, "file", apart);
    EXPECT_TRUE(apart.warnings.empty());
    add(9, 1, 2);
    RunContext context;
    warn_of_overlaps(mesh, regions, structures, "file", context);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-PIP-015");
    EXPECT_EQ(context.warnings[0].place.structure, "2 and liver");
    EXPECT_EQ(context.warnings[0].place.value, "0.167 mm3, 50 % of 2");
    EXPECT_NE(context.warnings[0].message.find("1 pair of"), std::string::npos);
    add(12, 1, 5);
    add(15, 1, 5);
    RunContext more;
    warn_of_overlaps(mesh, regions, structures, "file", more);
    ASSERT_EQ(more.warnings.size(), 1u);
    EXPECT_EQ(more.warnings[0].place.structure, "rib and liver");
    EXPECT_NE(more.warnings[0].message.find("2 pairs of"), std::string::npos);
}

}  // namespace
}  // namespace anatomesh::model_warnings_test
