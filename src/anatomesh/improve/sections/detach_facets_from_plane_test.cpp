#include "anatomesh/improve/sections/detach_facets_from_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/mesh/shape/cell_shape.h"
#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::detach_facets_from_plane_test {
namespace {

// A block of cubes that is a structure from z = 2 up, for x and y between 1 and 5, with all of z = 2 in a
// slice.
struct Block {
    TetMesh mesh = testing::brick_mesh({6, 6, 4}, [](int, int, int) { return Region{1}; });
    RegionTable table{{{}, {0}, {1}, {0, 1}}};
    std::vector<std::uint32_t> neighbors, slice_of;

    explicit Block(Region below = 0) {
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            Vec3 centre;
            for (const std::uint32_t v : mesh.cells[c]) centre += 0.25 * mesh.points[v];
            const bool across = centre.x > 1 && centre.x < 5 && centre.y > 1 && centre.y < 5;
            mesh.regions[c] = !across || centre.z < 1 || centre.z > 3 ? Region{0}
                              : centre.z > 2                          ? Region{1}
                                                                      : below;
        }
        for (const Vec3& p : mesh.points) slice_of.push_back(p.z == 2 ? 7 : no_slice);
        neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    }
    // With the least sine of the cells inside that new ones may have.
    DetachmentStats detach(const StructureField& field, double needed = 0.17) {
        std::vector<std::uint8_t> fixed(mesh.points.size(), 1);
        EditMesh edited(std::move(mesh), neighbors);
        EditContext edit(edited, fixed, {}, field, 2, {});
        edit.goal = 0.3;
        const DetachmentStats stats = detach_facets_from_plane(edit, {&table, slice_of}, needed, 1);
        mesh = std::move(edited).take(neighbors);
        return stats;
    }
    // The least sine and the largest ratio inside.
    std::array<double, 2> worst() const {
        std::array<double, 2> found{1, 0};
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            if (mesh.regions[c] == 0) continue;
            const Cell& v = mesh.cells[c];
            const CellMeasures m =
                measure_cell(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
            found = {std::min(found[0], m.least_sine()), std::max(found[1], std::sqrt(m.squared_ratio))};
        }
        return found;
    }
    double volume(std::uint32_t structure) const {
        return fixtures::structure_volume(mesh, table, structure);
    }
    // Facets in z = 2 between a cell above of structure 0 and one below that is not.
    std::vector<double> resting() const {
        std::vector<double> middles;  // their x
        for (std::size_t f = 0; f < neighbors.size(); ++f) {
            const Cell& cell = mesh.cells[f / 4];
            if (neighbors[f] == no_cell || !table.contains(mesh.regions[f / 4], 0) ||
                table.contains(mesh.regions[neighbors[f]], 0))
                continue;
            Vec3 middle;
            bool flat = true;
            for (const int n : facet_vertices[f % 4]) {
                middle += (1.0 / 3) * mesh.points[cell[n]];
                flat = flat && mesh.points[cell[n]].z == 2;
            }
            if (flat) middles.push_back(middle.x);
        }
        return middles;
    }
    void expect_sound() const {
        for (const Cell& v : mesh.cells)
            ASSERT_EQ(orient3d(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]),
                      1);
        EXPECT_EQ(neighbors, cell_neighbors(mesh.cells, mesh.points.size()));
        for (std::uint32_t s = 0; s < 2; ++s) {
            const auto surface = structure_surface(mesh, table, s);
            if (surface.empty()) continue;
            EXPECT_TRUE(surface_topology(surface).closed_manifold());
        }
    }
};

// What is drawn at z = 2: everything for x < 3.
fixtures::AnalyticField drawn_up_to_3() {
    return fixtures::AnalyticField({[](Vec3 p) { return p.x - 3; }, [](Vec3) { return 1.0; }}, 10);
}

TEST(DetachFacetsFromPlane, those_beside_what_is_drawn_leave_the_plane_and_those_in_it_stay) {
    Block block;
    EXPECT_EQ(block.resting().size(), 32u);
    const double before = block.volume(0);
    const std::vector<Vec3> points = block.mesh.points;
    const DetachmentStats stats = block.detach(drawn_up_to_3());
    EXPECT_EQ(stats.facets_detached, 16u);
    EXPECT_EQ(stats.facets_left, 0u);
    const std::vector<double> resting = block.resting();
    EXPECT_EQ(resting.size(), 16u);
    for (const double x : resting) EXPECT_LT(x, 3);
    block.expect_sound();
    // Less than the cells that rested, a sixth of a cube each.
    EXPECT_LT(block.volume(0), before);
    EXPECT_GT(block.volume(0), before - 16.0 / 6);
    EXPECT_TRUE(std::equal(points.begin(), points.end(), block.mesh.points.begin()));
}

TEST(DetachFacetsFromPlane, shapes_of_cells_keep_their_bound) {
    std::uint64_t most = 0;
    for (const double needed : {0.05, 0.17, 0.3, 0.6}) {
        Block block;
        const auto before = block.worst();
        const DetachmentStats stats = block.detach(drawn_up_to_3(), needed);
        EXPECT_EQ(block.resting().size(), 16u + stats.facets_left);
        EXPECT_GE(block.worst()[0], std::min(before[0], needed));
        EXPECT_LE(block.worst()[1], std::max(before[1], 3.9));
        block.expect_sound();
        most = std::max(most, stats.facets_left);
    }
    EXPECT_GT(most, 0u);  // where the bound asks too much
}

TEST(DetachFacetsFromPlane, the_part_below_goes_to_the_structure_that_is_drawn_there) {
    Block block(2);
    const double above = block.volume(0), below = block.volume(1);
    const fixtures::AnalyticField field({[](Vec3 p) { return p.x - 3; }, [](Vec3 p) { return 3 - p.x; }}, 10);
    const DetachmentStats stats = block.detach(field, 0.05);
    EXPECT_EQ(stats.facets_left, 0u);
    EXPECT_TRUE(block.resting().empty());
    block.expect_sound();
    // What the one loses the other gets, half the facets either way.
    EXPECT_NEAR(block.volume(0) + block.volume(1), above + below, 1e-12);
    EXPECT_NEAR(block.volume(0), above, 1);
}

TEST(DetachFacetsFromPlane, without_a_slice_or_with_another_region_across_nothing_is_done) {
    Block block;
    const std::vector<Region> before = block.mesh.regions;
    std::fill(block.slice_of.begin(), block.slice_of.end(), no_slice);
    EXPECT_EQ(block.detach(drawn_up_to_3()).facets_detached, 0u);
    EXPECT_EQ(block.mesh.regions, before);
    // Below lies structure 1, which is not drawn anywhere: it is detached off where structure 0 is drawn, and
    // beyond that neither side has what is drawn, which is nothing.
    Block other(2);
    const double above = other.volume(0);
    EXPECT_EQ(other.detach(drawn_up_to_3(), 0.05).facets_left, 0u);
    EXPECT_GT(other.volume(0), above);
    other.expect_sound();
}

}  // namespace
}  // namespace anatomesh::detach_facets_from_plane_test
