#include "anatomesh/measure/shells.h"

#include <gtest/gtest.h>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::shells_test {
namespace {

const RegionTable one_structure{{{}, {0}}};

// A row of 7 x 3 x 3 bricks in one structure, some left out; one contour round the row at z = 0.
struct Row {
    TetMesh mesh;
    std::vector<Triangle> surface;
    std::vector<std::uint32_t> shell_of;
    ContourSet contours;
    std::vector<std::uint32_t> vertex_of;

    explicit Row(const std::function<bool(int, int, int)>& is_there) {
        mesh = testing::brick_mesh({7, 3, 3}, [&](int i, int j, int k) { return Region(is_there(i, j, k)); });
        const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
        surface = structure_surface(mesh, neighbors, one_structure, 0);
        surface_topology(surface, &shell_of);
        contours.structures = {{1, "row", {}}};
        contours.slices.resize(1);
        contours.slices[0].name = "bottom";
        contours.contours = {{0, 0, 0, 4}};
        contours.points = {{0, 0, 0}, {7, 0, 0}, {7, 3, 0}, {0, 3, 0}};
        for (const Vec3& p : contours.points) {
            const auto found = std::find(mesh.points.begin(), mesh.points.end(), p);
            vertex_of.push_back(static_cast<std::uint32_t>(found - mesh.points.begin()));
        }
    }

    ShellReport report() const {
        ShellReport report = count_shells(mesh.points, surface, shell_of);
        look_for_contours(mesh.points, surface, shell_of, contours, std::vector<std::size_t>{0}, 0, vertex_of,
                          report);
        return report;
    }
};

TEST(Shells, a_whole_structure_has_one_that_its_contours_know) {
    const ShellReport report = Row([](int, int, int) { return true; }).report();
    EXPECT_EQ(report.voids, 0u);
    EXPECT_NEAR(report.smallest_mm3, 63, 1e-9);
    EXPECT_EQ(report.without_contour, 0u);
    EXPECT_EQ(report.contours_in_parts, 0u);
    EXPECT_EQ(report.parts_too_many, 0u);
}

TEST(Shells, a_cavity_that_no_contour_has_is_found_with_its_volume_and_place) {
    const ShellReport report = Row([](int i, int j, int k) { return i != 4 || j != 1 || k != 1; }).report();
    EXPECT_EQ(report.voids, 1u);
    EXPECT_NEAR(report.smallest_mm3, 1, 1e-9);
    EXPECT_EQ(report.without_contour, 1u);
    EXPECT_NEAR(report.largest_without_contour_mm3, 1, 1e-9);
    EXPECT_NEAR(report.largest_at[0], 4.5, 1e-9);
    EXPECT_NEAR(report.largest_at[1], 1.5, 1e-9);
    EXPECT_EQ(report.parts_too_many, 0u);
}

TEST(Shells, a_contour_that_runs_over_two_pieces_is_in_parts_and_a_piece_without_it_has_no_evidence) {
    // Gaps at x = 2 to 3 and 4 to 5: ends with contour vertices, and a piece of 9 mm3 between without any.
    const ShellReport report = Row([](int i, int, int) { return i != 2 && i != 4; }).report();
    EXPECT_EQ(report.voids, 0u);
    EXPECT_EQ(report.without_contour, 1u);
    EXPECT_NEAR(report.without_contour_mm3, 9, 1e-9);
    EXPECT_EQ(report.contours_in_parts, 1u);
    EXPECT_EQ(report.parts_too_many, 1u);
    EXPECT_EQ(report.worst_slice, "bottom");
}

TEST(Shells, two_pieces_with_a_contour_each_are_as_drawn) {
    Row row([](int i, int, int) { return i != 3; });
    row.contours.contours = {{0, 0, 0, 2}, {0, 0, 2, 2}};
    const auto at = [&](Vec3 p) {
        return static_cast<std::uint32_t>(std::find(row.mesh.points.begin(), row.mesh.points.end(), p) -
                                          row.mesh.points.begin());
    };
    row.vertex_of = {at({0, 0, 0}), at({0, 3, 0}), at({7, 0, 0}), at({7, 3, 0})};
    const ShellReport report = row.report();
    EXPECT_EQ(report.without_contour, 0u);
    EXPECT_EQ(report.parts_too_many, 0u);
}

}  // namespace
}  // namespace anatomesh::shells_test
