#include "anatomesh/cut/lift_facets.h"

#include <gtest/gtest.h>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/brick_mesh_for_test.h"
#include "anatomesh/mesh/quality.h"
#include "anatomesh/mesh/topology.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh {
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
    double volume(std::uint32_t structure) const {
        double sum = 0;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const Cell& v = mesh.cells[c];
            if (table.contains(mesh.regions[c], structure))
                sum +=
                    signed_volume(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
        }
        return sum;
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

TEST(LiftFacets, those_beside_what_is_drawn_leave_the_plane_and_those_in_it_stay) {
    Block block;
    EXPECT_EQ(block.resting().size(), 32u);
    const double before = block.volume(0);
    const std::vector<Vec3> points = block.mesh.points;
    const LiftStats stats =
        lift_facets(block.mesh, block.neighbors, block.table, block.slice_of, drawn_up_to_3(), {0.2, 10});
    EXPECT_EQ(stats.facets_lifted, 16u);
    const std::vector<double> resting = block.resting();
    EXPECT_EQ(resting.size(), 16u);
    for (const double x : resting) EXPECT_LT(x, 3);
    block.expect_sound();
    // A fifth of the way up in cells of a sixth of a cube each.
    EXPECT_NEAR(block.volume(0), before - 16 * 0.2 / 6, 1e-12);
    EXPECT_TRUE(std::equal(points.begin(), points.end(), block.mesh.points.begin()));
}

TEST(LiftFacets, shapes_of_cells_keep_their_bound) {
    for (const double bound : {1.2, 2.5, 3.5, 10.0}) {
        Block block;
        const auto worst = [&] {
            double ratio = 0;
            for (std::size_t c = 0; c < block.mesh.cells.size(); ++c) {
                const Cell& v = block.mesh.cells[c];
                const std::vector<Vec3>& p = block.mesh.points;
                if (block.mesh.regions[c])
                    ratio = std::max(ratio, radius_edge_ratio(p[v[0]], p[v[1]], p[v[2]], p[v[3]]));
            }
            return ratio;
        };
        const double before = worst();
        const LiftStats stats = lift_facets(block.mesh, block.neighbors, block.table, block.slice_of,
                                            drawn_up_to_3(), {0.2, bound});
        EXPECT_EQ(stats.facets_lifted + stats.facets_left, 16u);
        EXPECT_LE(worst(), std::max(before, bound));
        block.expect_sound();
    }
}

TEST(LiftFacets, the_part_below_goes_to_the_structure_that_is_drawn_there) {
    Block block(2);
    const double above = block.volume(0), below = block.volume(1);
    const fixtures::AnalyticField field({[](Vec3 p) { return p.x - 3; }, [](Vec3 p) { return 3 - p.x; }}, 10);
    EXPECT_EQ(
        lift_facets(block.mesh, block.neighbors, block.table, block.slice_of, field, {0.2, 10}).facets_lifted,
        32u);
    block.expect_sound();
    // Half the facets either way.
    EXPECT_NEAR(block.volume(0), above, 1e-12);
    EXPECT_NEAR(block.volume(1), below, 1e-12);
}

TEST(LiftFacets, without_a_slice_or_with_another_region_across_nothing_is_done) {
    Block block;
    const TetMesh before = block.mesh;
    std::fill(block.slice_of.begin(), block.slice_of.end(), no_slice);
    EXPECT_EQ(
        lift_facets(block.mesh, block.neighbors, block.table, block.slice_of, drawn_up_to_3()).facets_lifted,
        0u);
    EXPECT_EQ(block.mesh.cells, before.cells);
    // Below lies structure 1, which is not drawn anywhere: it is lifted off where structure 0 is drawn, and
    // beyond that neither side has what is drawn, which is nothing.
    Block other(2);
    const double above = other.volume(0);
    EXPECT_EQ(
        lift_facets(other.mesh, other.neighbors, other.table, other.slice_of, drawn_up_to_3(), {0.2, 10})
            .facets_lifted,
        16u);
    EXPECT_NEAR(other.volume(0), above + 16 * 0.2 / 6, 1e-12);
}

}  // namespace
}  // namespace anatomesh
