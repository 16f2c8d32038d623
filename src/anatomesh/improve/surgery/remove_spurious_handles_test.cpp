#include "anatomesh/improve/surgery/remove_spurious_handles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::remove_spurious_handles_test {
namespace {

constexpr int width = 8;
constexpr double any_shape = 1e-3, wall = 4, wide = 1000;  // the reach: of all there is

std::vector<std::uint32_t> nothing(std::vector<std::uint32_t>) {
    return {};
}

// Cells of a grid, the free vertices of which are shaken, in structures that hold cubes of it; and contours
// along edges of the grid. The field has the first structure where x < 4.
struct Grid {
    TetMesh mesh = testing::brick_mesh({width, width, width}, [](int, int, int) { return Region{1}; });
    RegionTable table;
    std::vector<std::uint32_t> neighbors, slice_of, contour_vertices;
    std::vector<std::uint8_t> fixed;
    std::vector<VertexPair> edges;
    std::vector<Contour> contours;
    ContourOwners owners;
    fixtures::AnalyticField field{{[](Vec3 p) { return p.x - wall; }, [](Vec3 p) { return p.x - wall; }}, 10};
    HandleRemovalStats stats;

    // `structures`: which cubes, by their middles, are theirs. `drawn`: loops of grid points, of the first.
    explicit Grid(const std::vector<std::function<bool(Vec3)>>& structures, unsigned seed = 1,
                  const std::vector<std::vector<Vec3>>& drawn = {}) {
        RegionRegistry registry;
        std::vector<std::uint32_t> members;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            Vec3 p;
            for (const std::uint32_t v : mesh.cells[c]) p += 0.25 * mesh.points[v];
            const auto middle = [](double x) { return std::floor(x) + 0.5; };
            members.clear();
            for (std::uint32_t s = 0; s < structures.size(); ++s) {
                if (structures[s]({middle(p.x), middle(p.y), middle(p.z)})) members.push_back(s);
            }
            mesh.regions[c] = registry.intern(members);
        }
        table = registry.table();
        neighbors = cell_neighbors(mesh.cells, mesh.points.size());
        slice_of.assign(mesh.points.size(), no_slice);
        draw(drawn);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> shift(-0.2, 0.2);
        for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
            Vec3& p = mesh.points[v];
            const bool rim = p.x == 0 || p.x == width || p.y == 0 || p.y == width || p.z == 0 || p.z == width;
            if (rim) fixed[v] = 1;
            if (!fixed[v]) p = p + Vec3{shift(random), shift(random), shift(random)};
        }
    }

    void draw(const std::vector<std::vector<Vec3>>& drawn) {
        fixed.assign(mesh.points.size(), 0);
        std::vector<std::array<std::uint32_t, 2>> vertices;
        std::vector<std::array<std::uint32_t, 3>> subsegments;
        for (const std::vector<Vec3>& loop : drawn) {
            Contour contour;
            contour.first_point = static_cast<std::uint32_t>(contour_vertices.size());
            contour.point_count = static_cast<std::uint32_t>(loop.size());
            contours.push_back(contour);
            for (const Vec3& p : loop) {
                const auto at = std::find(mesh.points.begin(), mesh.points.end(), p);
                ASSERT_NE(at, mesh.points.end());
                contour_vertices.push_back(static_cast<std::uint32_t>(at - mesh.points.begin()));
            }
            for (std::size_t n = 0; n < loop.size(); ++n) {
                const std::uint32_t a = contour_vertices[contour.first_point + n],
                                    b = contour_vertices[contour.first_point + (n + 1) % loop.size()];
                fixed[a] = 1;
                vertices.push_back({a, 0});
                subsegments.push_back({a, b, 0});
                edges.push_back({std::min(a, b), std::max(a, b)});
            }
        }
        std::sort(edges.begin(), edges.end());
        owners = ContourOwners(vertices, mesh.points.size(), subsegments);
    }

    // `told`: handles that a whole contour is drawn at stay.
    void close(bool told, double reach_mm = wide, double least_sine = any_shape,
               const ImproveCells& improve = nothing) {
        const TetMesh before = mesh;
        EditMesh edited(std::move(mesh), neighbors);
        MeshImprovementOptions options;
        options.spike_mm = 10;
        options.max_radius_edge = options.last_radius_edge = 100;
        EditContext edit(edited, fixed, edges, field, 2, options);
        edit.table = &table;
        DrawnSlices drawn{&table, slice_of, &owners};
        if (told) {
            drawn.routable.contours = contours;
            drawn.routable.vertices = contour_vertices;
        }
        stats = remove_spurious_handles(edit, drawn, reach_mm, least_sine, improve, {});
        mesh = std::move(edited).take(neighbors);
        fixtures::expect_sound_mesh(mesh, before);
        expect_contours();
    }

    SurfaceTopology topology(std::uint32_t structure = 0) const {
        return surface_topology(structure_surface(mesh, table, structure));
    }

    void expect_contours() const {
        std::vector<VertexPair> on;
        for (const Triangle& facet : structure_surface(mesh, table, 0)) {
            for (std::size_t k = 0; k < 3; ++k) {
                const auto [a, b] = std::minmax(facet[k], facet[(k + 1) % 3]);
                on.push_back({a, b});
            }
        }
        std::sort(on.begin(), on.end());
        EXPECT_TRUE(std::includes(on.begin(), on.end(), edges.begin(), edges.end()));
    }

    void expect_one_ball(std::uint32_t structure = 0) const {
        const SurfaceTopology topology = this->topology(structure);
        EXPECT_TRUE(topology.closed_manifold());
        EXPECT_EQ(topology.components, 1u);
        EXPECT_EQ(topology.genus, 0);
    }

    double volume() const { return fixtures::structure_volume(mesh, table, 0); }
};

// Plates that end within the grid, without and with a hole of a cube's width.
bool in_plate(Vec3 p, double from = 2) {
    return p.x > from && p.x < from + 2 && p.y > 1 && p.y < 7 && p.z > 1 && p.z < 7;
}
bool in_plate_with_hole(Vec3 p, double from = 2) {
    return in_plate(p, from) && !(p.y > 3 && p.y < 4 && p.z > 3 && p.z < 4);
}
bool first_plate(Vec3 p) {
    return in_plate_with_hole(p);
}

// A half space with an arch on it, where the field has nothing.
bool in_arch(Vec3 p) {
    return p.x < 4 || (p.y > 3 && p.y < 4 &&
                       ((p.x < 5 && ((p.z > 2 && p.z < 3) || (p.z > 4 && p.z < 5))) ||
                        (p.x > 5 && p.x < 6 && p.z > 2 && p.z < 5)));
}

TEST(RemoveSpuriousHandles, a_hole_that_nothing_tells_of_is_filled) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Grid grid({first_plate}, seed);
        ASSERT_EQ(grid.topology().genus, 1);
        const double before = grid.volume();
        grid.close(true);
        EXPECT_EQ(grid.stats.found, 1u);
        EXPECT_EQ(grid.stats.removed, 1u);
        EXPECT_FALSE(grid.stats.changed.empty());
        EXPECT_GT(grid.volume(), before);
        grid.expect_one_ball();
    }
}

TEST(RemoveSpuriousHandles, a_bridge_where_the_field_has_none_is_cut) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Grid grid({in_arch}, seed);
        ASSERT_EQ(grid.topology().genus, 1);
        const double before = grid.volume();
        grid.close(true, 5);
        EXPECT_EQ(grid.stats.removed, 1u);
        EXPECT_LT(grid.volume(), before);
        grid.expect_one_ball();
    }
}

TEST(RemoveSpuriousHandles, what_is_larger_than_the_reach_or_drawn_is_left_as_it_is) {
    const std::vector<Vec3> round_the_hole{{3, 3, 3}, {3, 4, 3}, {3, 4, 4}, {3, 3, 4}};
    for (const bool drawn : {false, true}) {
        Grid grid({first_plate}, 1, std::vector<std::vector<Vec3>>(drawn ? 1 : 0, round_the_hole));
        const TetMesh before = grid.mesh;
        grid.close(true, drawn ? wide : 3);
        EXPECT_EQ(grid.stats.found, 0u);
        EXPECT_EQ(grid.mesh.points, before.points);
        EXPECT_EQ(grid.mesh.cells, before.cells);
        EXPECT_EQ(grid.mesh.regions, before.regions);
    }
}

// Through the hole and round the plate's edge: whatever would close the hole would bury a part of it.
TEST(RemoveSpuriousHandles, what_a_contour_runs_through_is_left_open) {
    std::vector<Vec3> through;
    for (int x = 2; x < 4; ++x) through.push_back({double(x), 3, 3});
    for (int y = 3; y > 1; --y) through.push_back({4, double(y), 3});
    for (int x = 4; x > 2; --x) through.push_back({double(x), 1, 3});
    for (int y = 1; y < 3; ++y) through.push_back({2, double(y), 3});
    Grid grid({first_plate}, 1, {through});
    grid.close(false);
    EXPECT_EQ(grid.stats.found, 1u);
    EXPECT_EQ(grid.stats.removed, 0u);
    EXPECT_EQ(grid.topology().genus, 1);
}

// A contour that comes to the hole's rim from one side, and turns there, stays on the surface.
TEST(RemoveSpuriousHandles, contours_beside_a_hole_stay_on_the_surface) {
    const std::vector<Vec3> beside{{4, 3, 3}, {4, 4, 3}, {4, 4, 2}, {4, 3, 2}};
    int removed = 0;
    for (unsigned seed = 0; seed < 10; ++seed) {
        Grid grid({first_plate}, seed, {beside});
        grid.close(false);
        removed += grid.topology().genus == 0;
    }
    EXPECT_EQ(removed, 10);
}

TEST(RemoveSpuriousHandles, holes_through_neighbours_and_through_what_lies_in_another_are_filled) {
    for (unsigned seed = 0; seed < 5; ++seed) {
        for (const bool nested : {false, true}) {
            const auto second = [&](Vec3 p) {
                return in_plate_with_hole(p, 4) || (nested && in_plate_with_hole(p));
            };
            Grid grid({first_plate, second}, seed);
            ASSERT_EQ(grid.topology(0).genus, 1);
            ASSERT_EQ(grid.topology(1).genus, 1);
            grid.close(true);
            grid.expect_one_ball(0);
            grid.expect_one_ball(1);
        }
    }
}

TEST(RemoveSpuriousHandles, all_is_as_it_was_where_cells_are_too_flat) {
    Grid grid({first_plate});
    const TetMesh before = grid.mesh;
    std::size_t asked = 0;
    grid.close(true, wide, 0.99, [&](std::vector<std::uint32_t> cells) {
        asked += cells.size();
        return std::vector<std::uint32_t>{};
    });
    EXPECT_GT(asked, 0u);
    EXPECT_EQ(grid.stats.found, 1u);
    EXPECT_EQ(grid.stats.removed, 0u);
    EXPECT_EQ(grid.mesh.cells, before.cells);
    EXPECT_EQ(grid.mesh.regions, before.regions);
}

// A plate with holes and arches on it: surfaces stay manifolds of as many shells, and lose the handles that
// are said to be closed.
TEST(RemoveSpuriousHandles, of_many_holes_and_bridges_nothing_else_goes) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        std::mt19937 random(seed);
        std::array<unsigned, 9> kind{};
        for (unsigned& k : kind) k = random() % 3;
        // By three times three places, 0: nothing, 1: a hole, 2: an arch.
        const auto kind_at = [&](int j, int k) {
            return j % 2 == 1 && k % 2 == 1 && j < 7 && k < 7
                       ? kind[static_cast<std::size_t>(j / 2 * 3 + k / 2)]
                       : 0u;
        };
        Grid grid({[&](Vec3 p) {
                      const auto i = static_cast<int>(p.x), j = static_cast<int>(p.y),
                                 k = static_cast<int>(p.z);
                      if (in_plate(p)) return kind_at(j, k) != 1;
                      // Over two places the second of which has no hole.
                      const bool first = kind_at(j, k) == 2 && kind_at(j, k + 2) == 2 && k == 1,
                                 second = kind_at(j, k) == 2 && kind_at(j, k - 2) == 2 && k == 3,
                                 between = k == 2 && kind_at(j, 1) == 2 && kind_at(j, 3) == 2;
                      return ((i == 4 || i == 5) && (first || second)) || (i == 5 && between);
                  }},
                  seed);
        const SurfaceTopology before = grid.topology();
        ASSERT_TRUE(before.closed_manifold());
        grid.close(true);
        const SurfaceTopology after = grid.topology();
        EXPECT_TRUE(after.closed_manifold());
        EXPECT_EQ(after.components, before.components);
        EXPECT_EQ(grid.stats.found, static_cast<std::uint64_t>(before.genus));
        EXPECT_EQ(grid.stats.removed, grid.stats.found);
        EXPECT_EQ(after.genus, 0);
    }
}

}  // namespace
}  // namespace anatomesh::remove_spurious_handles_test
