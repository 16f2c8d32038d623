#include "anatomesh/measure/certificate/certificate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "anatomesh/base/contract.h"
#include "anatomesh/measure/contour_fidelity.h"
#include "anatomesh/measure/quality_report.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::certificate_test {
namespace {

const RegionTable one_structure{{{}, {0}}};

Region everywhere(int, int, int) {
    return 1;
}

// A 4 x 4 x 4 block and, in each of its inner planes, the square that bounds it, with the block's own
// vertices.
struct Case {
    TetMesh mesh = testing::brick_mesh({4, 4, 4}, everywhere);
    std::vector<Structure> structures{{7, "block", {1, 2, 3}}};
    ContourSet contours;

    Case() {
        contours.structures = structures;
        for (int k = 0; k < 3; ++k) {
            const double z = k + 1;
            Slice slice;
            slice.plane = make_plane({0, 0, z}, {0, 0, 1});
            slice.first_contour = static_cast<std::uint32_t>(k);
            slice.contour_count = 1;
            slice.name = "k = " + std::to_string(k);
            contours.slices.push_back(slice);
            contours.contours.push_back(
                {0, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(4 * k), 4});
            for (const Vec2 p : {Vec2{0, 0}, Vec2{4, 0}, Vec2{4, 4}, Vec2{0, 4}}) {
                contours.points.push_back({p.x, p.y, z});
            }
        }
    }

    ModelReport measure(bool with_contours, std::vector<double> field_volumes = {},
                        std::vector<Warning> warnings = {}) const {
        ModelReport report;
        RunContext context;
        context.warnings = std::move(warnings);
        measure_model({mesh, one_structure, structures, with_contours ? &contours : nullptr, field_volumes},
                      context, report);
        return report;
    }
};

TEST(Certificate, a_sound_model_keeps_what_is_promised) {
    const ModelReport report = Case().measure(true, {64.0});
    ASSERT_EQ(report.certificate.size(), 6u);
    for (const int number : {1, 3, 4, 5, 6}) {
        const Clause& clause = report.certificate[static_cast<std::size_t>(number - 1)];
        EXPECT_EQ(clause.number, number);
        EXPECT_EQ(clause.state, ClauseState::kept) << clause.evidence;
    }
    EXPECT_EQ(report.certificate[1].state, ClauseState::kept) << report.certificate[1].evidence;
    EXPECT_FALSE(any_broken(report.certificate));
    EXPECT_EQ(report.certificate[0].evidence,
              "12 of 12 contour vertices are vertices of their structure's surface, bit for bit");

    const StructureReport& structure = report.structures.at(0);
    EXPECT_EQ(structure.number, 7);
    EXPECT_EQ(structure.tetrahedra, 384u);
    EXPECT_EQ(structure.surface.components, 1u);
    EXPECT_EQ(structure.pieces, 1u);
    EXPECT_EQ(structure.surface.genus, 0);
    EXPECT_NEAR(structure.volume.mesh_mm3, 64.0, 1e-12);
    EXPECT_DOUBLE_EQ(structure.surface.area_mm2, 96.0);
    EXPECT_DOUBLE_EQ(structure.volume.slices_mm3, 48.0);
    EXPECT_EQ(structure.fidelity.segments, 12u);
    EXPECT_EQ(structure.fidelity.segments_on_surface, 12u);  // each a chain of four edges
    EXPECT_EQ(report.counts.slices, 3u);
    EXPECT_DOUBLE_EQ(report.lengths.slice_spacing_mm, 1.0);
    EXPECT_EQ(report.listed_cells.total, 0u);
}

TEST(Certificate, without_contours_and_field_their_clauses_are_not_checked) {
    const ModelReport report = Case().measure(false);
    for (const std::size_t clause : {0u, 1u, 5u}) {
        EXPECT_EQ(report.certificate[clause].state, ClauseState::not_promised_yet);
        EXPECT_EQ(report.certificate[clause].evidence.rfind("not checked", 0), 0u);
    }
    EXPECT_EQ(report.certificate[2].state, ClauseState::kept);
}

TEST(Certificate, a_contour_vertex_off_by_one_bit_breaks_clause_1) {
    Case off;
    off.contours.points[5].y = std::nextafter(0.0, 1.0);
    const ModelReport report = off.measure(true);
    EXPECT_EQ(report.certificate[0].state, ClauseState::broken);
    EXPECT_EQ(report.structures[0].fidelity.vertices_on_surface, 11u);
    EXPECT_EQ(report.structures[0].fidelity.segments_on_surface, 10u);
    EXPECT_TRUE(any_broken(report.certificate));
}

TEST(Certificate, clause_2_says_how_many_of_the_segments_missed_another_slice_contradicts) {
    Case crossed;
    // Of the three slices the middle one, and one across it with a contour within the block but for its ends.
    crossed.contours.slices = {crossed.contours.slices[1], crossed.contours.slices[1]};
    crossed.contours.slices[0].first_contour = 0;
    crossed.contours.slices[1].plane = make_plane({2, 0, 0}, {1, 0, 0});
    crossed.contours.slices[1].first_contour = 1;
    crossed.contours.contours = {{0, 0, 0, 4}, {0, 1, 4, 4}};
    crossed.contours.points = {{0, 0, 2}, {4, 0, 2}, {4, 4, 2}, {0, 4, 2},
                               {2, 1, 0}, {2, 3, 0}, {2, 3, 4}, {2, 1, 4}};
    const ModelReport report = crossed.measure(true);
    const StructureReport& structure = report.structures.at(0);
    EXPECT_EQ(structure.fidelity.segments, 8u);
    EXPECT_EQ(structure.fidelity.segments_on_surface, 6u);
    EXPECT_EQ(structure.fidelity.segments_contradicted, 2u);
    EXPECT_NE(report.certificate[1].evidence.find(
                  "2 of the others cross another slice where that slice contradicts them"),
              std::string::npos)
        << report.certificate[1].evidence;
    EXPECT_EQ(Case().measure(true).certificate[1].evidence.find("contradicts them"), std::string::npos);
}

TEST(Certificate, clause_1_says_what_cleaning_moved_before) {
    const std::vector<Warning> warnings{
        {"W-CON-020", "two rings touch", {"", "", "", "", "3 vertices"}, "moved apart by 0.05 mm"},
        {"W-CON-020", "two rings touch", {"", "", "", "", "1 vertex"}, "moved apart by 0.01 mm"},
        {"W-CON-021", "12 vertices differ from one of another structure", {}, "moved onto it"},
        {"W-CON-003", "a contour of fewer than three points", {}, "left out"}};
    EXPECT_EQ(
        Case().measure(true, {}, warnings).certificate[0].evidence,
        "12 of 12 contour vertices are vertices of their structure's surface, bit for bit; vertices that "
        "cleaning moved before: 4 moved apart where contours touch (W-CON-020), 12 moved onto one of another "
        "structure (W-CON-021)");
}

TEST(Certificate, a_contour_vertex_inside_the_solid_is_not_on_the_surface) {
    Case inside;
    inside.contours.points[5] = {2, 2, 2};
    EXPECT_EQ(inside.measure(true).structures[0].fidelity.vertices_on_surface, 11u);
}

TEST(Certificate, a_structure_that_the_model_lacks_breaks_clause_1) {
    Case lacking;
    lacking.contours.structures = {{9, "other", {}}, {7, "block", {}}};
    const ModelReport report = lacking.measure(true);
    EXPECT_EQ(report.certificate[0].state, ClauseState::broken);
    EXPECT_EQ(report.structures[0].fidelity.vertices, 0u);
}

TEST(Certificate, faults_of_the_mesh_break_clause_3) {
    Case twice;
    twice.mesh.cells.push_back(twice.mesh.cells[5]);
    twice.mesh.regions.push_back(1);
    EXPECT_EQ(twice.measure(true).certificate[2].state, ClauseState::broken);

    Case touching;
    touching.mesh =
        testing::brick_mesh({2, 2, 2}, [](int i, int j, int k) { return Region(i == j && j == k); });
    EXPECT_EQ(touching.measure(false).structures[0].surface.nonmanifold_vertices, 1u);
    EXPECT_EQ(touching.measure(false).certificate[2].state, ClauseState::broken);

    Case lost;
    lost.mesh.cells[0][0] = 99999;
    const ModelReport report = lost.measure(true);
    ASSERT_EQ(report.certificate.size(), 1u);
    EXPECT_EQ(report.certificate[0].state, ClauseState::broken);
}

TEST(Certificate, cuts_that_are_grossly_amiss_break_clause_2_and_the_structure_and_slices_are_named) {
    // A shaft of one brick in sixteen, and of four.
    Case narrow;
    narrow.mesh = testing::brick_mesh({4, 4, 4}, [](int i, int j, int) { return Region(i != 1 || j != 1); });
    const Clause few = narrow.measure(true).certificate[1];
    EXPECT_EQ(few.state, ClauseState::not_promised_yet);
    EXPECT_EQ(few.evidence.find("amiss"), std::string::npos) << few.evidence;

    Case wide;
    wide.mesh = testing::brick_mesh(
        {4, 4, 4}, [](int i, int j, int) { return Region(i < 1 || i > 2 || j < 1 || j > 2); });
    const ModelReport report = wide.measure(true);
    EXPECT_EQ(report.certificate[1].state, ClauseState::broken);
    EXPECT_EQ(report.certificate[1].evidence.rfind("measured, not met: of all slices together 25.0 % of the "
                                                   "drawn area of block are wrong, more than "
                                                   "10 % (most on block, slice k = 0: 4.00 of 16.00 mm2; ",
                                                   0),
              0u)
        << report.certificate[1].evidence;
    EXPECT_EQ(report.structures[0].fidelity.segments_on_surface, 12u);
}

TEST(Certificate, a_grossly_wrong_structure_is_found_beside_a_right_one_of_the_same_name) {
    // A plate of one brick in four, of which a quarter is missing, beside a block that is as drawn.
    const TetMesh mesh = testing::brick_mesh({4, 4, 4}, [](int i, int j, int) {
        return Region(i < 3 ? 1 : j == 1 ? 0 : 2);
    });
    const std::vector<Structure> structures{{7, "block", {1, 2, 3}}, {8, "block", {1, 2, 3}}};
    ContourSet contours;
    contours.structures = structures;
    for (std::uint32_t k = 0; k < 3; ++k) {
        const double z = k + 1;
        Slice slice;
        slice.plane = make_plane({0, 0, z}, {0, 0, 1});
        slice.first_contour = 2 * k;
        slice.contour_count = 2;
        contours.slices.push_back(slice);
        for (std::uint32_t s = 0; s < 2; ++s) {
            contours.contours.push_back({s, k, 8 * k + 4 * s, 4});
            const double low = s == 0 ? 0 : 3, high = s == 0 ? 3 : 4;
            for (const Vec2 p : {Vec2{low, 0}, Vec2{high, 0}, Vec2{high, 4}, Vec2{low, 4}})
                contours.points.push_back({p.x, p.y, z});
        }
    }
    ModelReport report;
    RunContext context;
    const RegionTable regions{{{}, {0}, {1}}};
    measure_model({mesh, regions, structures, &contours}, context, report);
    EXPECT_EQ(report.certificate[1].state, ClauseState::broken);
    EXPECT_NE(report.certificate[1].evidence.find("25.0 % of the drawn area of block are wrong"),
              std::string::npos)
        << report.certificate[1].evidence;
    EXPECT_NE(report.certificate[1].evidence.find("slice 0: 1.00 of 4.00 mm2"), std::string::npos)
        << report.certificate[1].evidence;
}

TEST(Certificate, a_volume_off_by_more_than_its_bound_breaks_clause_6) {
    EXPECT_EQ(Case().measure(true, {64.1}).certificate[5].state, ClauseState::kept);
    EXPECT_EQ(Case().measure(true, {64.2}).certificate[5].state, ClauseState::broken);
    EXPECT_EQ(Case().measure(true, {0.0}).certificate[5].state, ClauseState::broken);
}

TEST(Certificate, flat_cells_are_listed_with_what_forces_them) {
    Case squeezed;
    // Squeezed to a thin plate: all cells get a large ratio.
    for (Vec3& p : squeezed.mesh.points) p.x *= 0.01;
    for (Vec3& p : squeezed.contours.points) p.x *= 0.01;
    const ModelReport report = squeezed.measure(true);
    EXPECT_EQ(report.listed_cells.total, 384u);
    EXPECT_EQ(report.listed_cells.cells.size(), 384u);
    EXPECT_GE(report.listed_cells.cells[0].value, report.listed_cells.cells[1].value);
    EXPECT_EQ(report.certificate[3].state, ClauseState::broken);
    EXPECT_DOUBLE_EQ(report.quality.radius_edge.share_over_2, 1.0);
    EXPECT_GT(report.quality.dihedral_deg.below_10, 0u);
}

// A block one cell wide, all vertices of which are contour vertices, and these so far apart.
TEST(Certificate, cells_too_flat_for_any_use_are_said_though_contours_force_them) {
    for (const double apart : {0.1, 1e-5}) {
        SCOPED_TRACE(apart);
        Case thin;
        thin.mesh = testing::brick_mesh({1, 1, 4}, everywhere);
        for (Vec3& p : thin.mesh.points) p.x *= apart;
        for (Vec3& p : thin.contours.points) p = {p.x > 0 ? apart : 0, p.y > 0 ? 1.0 : 0.0, p.z};
        for (const double z : {0.0, 4.0}) {
            Slice slice = thin.contours.slices[0];
            slice.plane = make_plane({0, 0, z}, {0, 0, 1});
            slice.first_contour = static_cast<std::uint32_t>(thin.contours.contours.size());
            thin.contours.contours.push_back({0, static_cast<std::uint32_t>(thin.contours.slices.size()),
                                              static_cast<std::uint32_t>(thin.contours.points.size()), 4});
            thin.contours.slices.push_back(slice);
            for (int n = 0; n < 4; ++n) {
                const Vec3 p = thin.contours.points[static_cast<std::size_t>(n)];
                thin.contours.points.push_back({p.x, p.y, z});
            }
        }
        const ModelReport report = thin.measure(true);
        EXPECT_EQ(report.listed_cells.total, report.counts.tetrahedra);
        EXPECT_EQ(report.listed_cells.forced, report.counts.tetrahedra);
        const Clause& clause = report.certificate[3];
        EXPECT_EQ(clause.state, apart < 0.01 ? ClauseState::not_promised_yet : ClauseState::kept);
        EXPECT_EQ(clause.evidence.find("of those that contours force (at ") != std::string::npos,
                  apart < 0.01)
            << clause.evidence;
    }
}

// The clause of shape of a brick mesh of 32 x 32 x 8 cells in which `spoiled` inner vertices were moved next
// to a neighbour, with the contours or without.
Clause shape_of_spoiled(int spoiled, double distance, bool with_contours) {
    Case spoilt;
    spoilt.mesh = testing::brick_mesh({32, 32, 8}, everywhere);
    for (Vec3& p : spoilt.mesh.points) {
        const bool inner = p.x > 0 && p.x < 32 && p.y > 0 && p.y < 32 && p.z > 0 && p.z < 8;
        if (!inner || spoiled == 0 || std::fmod(p.x, 2) != 1 || std::fmod(p.y, 2) != 1 || p.z != 4) continue;
        p.x += 1 - distance;
        --spoiled;
    }
    return spoilt.measure(with_contours).certificate[3];
}

TEST(Certificate, cells_above_the_bound_that_nothing_forces_are_kept_only_while_few) {
    EXPECT_EQ(shape_of_spoiled(0, 0, false).state, ClauseState::kept);
    // Of 49,152 cells 245 may be above the bound; each spoiled vertex makes a few such.
    EXPECT_EQ(shape_of_spoiled(4, 0.3, false).state, ClauseState::kept)
        << shape_of_spoiled(4, 0.3, false).evidence;
    EXPECT_EQ(shape_of_spoiled(200, 0.2, false).state, ClauseState::broken);
}

TEST(Certificate, one_cell_that_is_bad_and_that_nothing_forces_is_said_and_a_gross_one_breaks_clause_4) {
    for (const bool with_contours : {false, true}) {
        const Clause bad = shape_of_spoiled(1, 0.08, with_contours);
        EXPECT_EQ(bad.state, ClauseState::not_promised_yet) << bad.evidence;
        EXPECT_EQ(bad.evidence.rfind("measured, not met: ", 0), 0u) << bad.evidence;
        EXPECT_NE(bad.evidence.find("(at "), std::string::npos) << bad.evidence;
        // A ratio of some hundreds: too few to matter for the mean.
        const Clause gross = shape_of_spoiled(1, 0.002, with_contours);
        EXPECT_EQ(gross.state, ClauseState::broken) << gross.evidence;
    }
}

TEST(Certificate, a_few_cells_that_spoil_the_mean_break_clause_4) {
    // One vertex all but on its neighbour: few cells, ratios of a million.
    const Clause clause = shape_of_spoiled(1, 1e-6, false);
    EXPECT_EQ(clause.state, ClauseState::broken) << clause.evidence;
    // Flat cells: a ratio without end.
    const Clause flat = shape_of_spoiled(1, 0, false);
    EXPECT_EQ(flat.state, ClauseState::broken) << flat.evidence;
    EXPECT_NE(flat.evidence.find("mean inf"), std::string::npos) << flat.evidence;
}

TEST(Certificate, evidence_of_shape_says_how_many_of_how_many_and_what_is_not_known) {
    EXPECT_EQ(shape_of_spoiled(0, 0, false)
                  .evidence.rfind(
                      "radius-edge: 0 of 49152 (0.000 %) above 2, the reason is not known without contours, "
                      "mean 0.866, maximum 0.87; ",
                      0),
              0u)
        << shape_of_spoiled(0, 0, false).evidence;
    EXPECT_NE(
        shape_of_spoiled(4, 0.2, true).evidence.find("above 2, 0 of them forced by contour points, mean 0."),
        std::string::npos)
        << shape_of_spoiled(4, 0.2, true).evidence;
}

TEST(Certificate, coarse_cells_within_the_bound_keep_clause_4_whatever_their_mean) {
    Case stretched;
    for (Vec3& p : stretched.mesh.points) p.x *= 2.5;
    const ModelReport report = stretched.measure(false);
    EXPECT_GT(report.quality.radius_edge.mean, contract::mean_radius_edge);
    EXPECT_EQ(report.listed_cells.total, 0u);
    EXPECT_EQ(report.certificate[3].state, ClauseState::kept);
}

// In slices of their own, their points to be given.
ContourSet two_triangles() {
    ContourSet contours;
    contours.structures = {{1, "s", {}}};
    contours.slices.resize(2);
    contours.slices[0].name = "k = 7";
    contours.slices[1].name = "k = 8";
    contours.contours = {{0, 0, 0, 3}, {0, 1, 3, 3}};
    return contours;
}

TEST(ForcedCells, names_the_contour_vertices_of_the_shortest_edge_and_the_sharp_angle) {
    TetMesh mesh;
    mesh.points = {{0, 0, 0}, {0.25, 0, 0}, {0, 3, 0}, {0, 0, 4}};
    mesh.cells = {{0, 1, 2, 3}};
    mesh.regions = {1};
    ContourSet contours = two_triangles();
    contours.points = {{0, 0, 0}, {0.25, 0, 0}, {9, 9, 0}, {0, 0, 4}, {9, 0, 4}, {9, 1, 4}};

    EXPECT_EQ(
        ForcedCells(mesh, contours, std::vector<std::uint32_t>{0, 1, no_cell, no_cell, no_cell, no_cell})
            .reason(0),
        "contour vertices 0 and 1 0.250 mm apart in slice k = 7");
    EXPECT_EQ(
        ForcedCells(mesh, contours, std::vector<std::uint32_t>{no_cell, 1, no_cell, 0, no_cell, no_cell})
            .reason(0),
        "contour vertices 1 and 3 0.250 mm apart in slices k = 7 and k = 8");
    EXPECT_EQ(ForcedCells(mesh, contours,
                          std::vector<std::uint32_t>{no_cell, no_cell, no_cell, 3, no_cell, no_cell})
                  .reason(0),
              "an angle of 6.3 degrees at contour vertex 3 in slice k = 8");
    EXPECT_EQ(ForcedCells(mesh, {}, {}).reason(0), "");
    // The contour of slice k = 8 passes the vertex (0, 0, 0) at 0.01 mm.
    contours.points = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {-5, 0.01, 0}, {5, 0.01, 0}, {0, 9, 0}};
    const std::vector<std::uint32_t> vertices{0, no_cell, no_cell, no_cell, no_cell, no_cell};
    ForcedCells constraint_limited(mesh, contours, vertices);
    EXPECT_EQ(constraint_limited.reason(0), "");
    constraint_limited.find_constraint_limited(std::vector<std::uint32_t>{0}, 0.02);
    EXPECT_EQ(constraint_limited.reason(0),
              "contour vertex 0 in slice k = 7 0.0100 mm from the contour at vertex 3 in slice k = 8");
    ForcedCells free(mesh, contours, vertices);
    free.find_constraint_limited(std::vector<std::uint32_t>{0}, 0.005);
    EXPECT_EQ(free.reason(0), "");
}

TEST(ForcedCells, names_contours_that_pass_each_other_or_meet_at_a_small_angle) {
    TetMesh mesh;
    mesh.points = {{1, 0, 0}, {0.25, 2, 0}, {0, 3, 0}, {0, 0, 4}};
    mesh.cells = {{0, 1, 2, 3}};
    mesh.regions = {1};
    ContourSet contours = two_triangles();
    const auto reason = [&](std::vector<Vec3> points, std::vector<std::uint32_t> vertex_of, double distance) {
        contours.points = std::move(points);
        ForcedCells forced(mesh, contours, vertex_of);
        forced.find_constraint_limited(std::vector<std::uint32_t>{0}, distance);
        return forced.reason(0);
    };
    // (1, 0, 0) is no vertex of a contour, but lies on one, and the other one passes at 0.01 mm.
    const std::vector<std::uint32_t> none(6, no_cell);
    const std::vector<Vec3> passing{{0, 0, 0}, {9, 0, 0}, {4, -9, 0}, {1, -5, 0.01}, {1, 5, 0.01}, {9, 9, 9}};
    EXPECT_EQ(
        reason(passing, none, 0.02),
        "the contour from vertex 0 in slice k = 7 0.0100 mm from the contour at vertex 3 in slice k = 8");
    EXPECT_EQ(reason(passing, none, 0.005), "");
    // Where its own contour goes on it is as near, and that forces nothing.
    const std::vector<Vec3> going_on{{0.99, 0, 0}, {9, 0, 0}, {0.99, -9, 0},
                                     {1, -5, 5},   {1, 5, 5}, {9, 9, 9}};
    EXPECT_EQ(reason(going_on, none, 0.02), "");
    // Two contours meet in a vertex at 20 or 40 degrees, each turning by more than 60.
    const auto meeting = [](double degrees) {
        const double angle = degrees * std::numbers::pi / 180;
        const Vec3 along{5 * std::cos(angle), 5 * std::sin(angle), 0};
        return std::vector<Vec3>{{1, 0, 0}, {6, 0, 0}, {1, 0, -5}, {1, 0, 0}, Vec3{1, 0, 0} + along,
                                 {1, 0, 5}};
    };
    const std::vector<std::uint32_t> shared{0, no_cell, no_cell, 0, no_cell, no_cell};
    EXPECT_EQ(reason(meeting(20), shared, 0.02),
              "an angle of 20.0 degrees between the contours at vertex 0 in slice k = 7 and at vertex 3 in "
              "slice k = 8");
    EXPECT_EQ(reason(meeting(40), shared, 0.02), "");
}

TEST(QualityReport, figures_of_cubes_cut_in_six) {
    RunContext context;
    const CellShapes shapes = measure_shapes(testing::brick_mesh({3, 3, 3}, everywhere), context);
    const QualityReport& report = shapes.report;
    // Each such cell has the cube's circumradius, sqrt(3) / 2, and dihedral angles of 45, 60 and 90 degrees.
    EXPECT_NEAR(report.radius_edge.mean, std::sqrt(3.0) / 2, 1e-12);
    EXPECT_NEAR(report.radius_edge.max, std::sqrt(3.0) / 2, 1e-12);
    EXPECT_NEAR(report.dihedral_deg.min, 45.0, 1e-9);
    EXPECT_NEAR(report.dihedral_deg.max, 90.0, 1e-9);
    EXPECT_DOUBLE_EQ(report.edge_mm.min, 1.0);
    EXPECT_DOUBLE_EQ(report.edge_mm.max, std::sqrt(3.0));
    EXPECT_EQ(report.radius_edge.histogram.counts.size(), 50u);
    EXPECT_EQ(report.radius_edge.histogram.counts[7], 162u);  // 0.85 to 0.90
    EXPECT_EQ(measure_shapes({}, context).report.edge_mm.max, 0.0);
}

}  // namespace
}  // namespace anatomesh::certificate_test
