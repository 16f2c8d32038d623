// Cubes that meet in edges and corners only: shapes whose singular edges and vertices are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>

#include "anatomesh/cut/relabel.h"
#include "anatomesh/cut/resolve_nonmanifold.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh::split_shapes_test {
namespace {

// A grid of n^3 cubes in which every cube has a region; those at the border are outside.
struct Cubes {
    TetMesh mesh;
    std::vector<CellNeighbors> neighbors;
    RegionRegistry registry;
    int n;

    // set(i, j, k): the structures of an inner cube.
    Cubes(int side, const std::function<std::vector<std::uint32_t>(int, int, int)>& set) : n(side) {
        mesh = testing::brick_mesh({n, n, n}, [](int, int, int) { return Region{1}; });
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            Vec3 centre;
            for (const std::uint32_t v : mesh.cells[c]) centre += 0.25 * mesh.points[v];
            const int i = static_cast<int>(centre.x), j = static_cast<int>(centre.y),
                      k = static_cast<int>(centre.z);
            const bool border = std::min({i, j, k}) == 0 || std::max({i, j, k}) == n - 1;
            mesh.regions[c] = border ? Region{0} : registry.intern(set(i, j, k));
        }
        const std::vector<std::uint32_t> flat = cell_neighbors(mesh.cells, mesh.points.size());
        neighbors.resize(mesh.cells.size());
        for (std::size_t f = 0; f < flat.size(); ++f) neighbors[f / 4][f % 4] = flat[f];
    }
    std::vector<std::uint32_t> all_vertices() const {
        std::vector<std::uint32_t> all(mesh.points.size());
        for (std::uint32_t v = 0; v < all.size(); ++v) all[v] = v;
        return all;
    }
    SurfaceTopology topology(std::uint32_t structure) const {
        return surface_topology(structure_surface(mesh, registry.table(), structure));
    }
    double volume(std::uint32_t structure) const {
        double sum = 0;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const Cell& v = mesh.cells[c];
            if (!registry.table().contains(mesh.regions[c], structure)) continue;
            sum += signed_volume(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
        }
        return sum;
    }
};

NonmanifoldStats split(Cubes& cubes, const ContourOwners& owners = {}) {
    const auto done = resolve_nonmanifold(cubes.mesh, cubes.all_vertices(), owners, cubes.registry, {});
    EXPECT_TRUE(done.ok()) << to_line(done.error());
    return done.ok() ? done.value() : NonmanifoldStats{};
}

std::vector<std::uint32_t> structure_if(bool inside) {
    return inside ? std::vector<std::uint32_t>{0} : std::vector<std::uint32_t>{};
}

void expect_manifold(const Cubes& cubes, std::uint32_t structures) {
    for (const Cell& v : cubes.mesh.cells) {
        const std::vector<Vec3>& p = cubes.mesh.points;
        ASSERT_EQ(orient3d(p[v[0]], p[v[1]], p[v[2]], p[v[3]]), 1);
    }
    for (std::uint32_t s = 0; s < structures; ++s) EXPECT_TRUE(cubes.topology(s).closed_manifold());
}

TEST(SplitShapes, a_manifold_is_left_as_it_is) {
    Cubes cubes(5, [](int i, int, int) { return structure_if(i == 2); });
    const TetMesh before = cubes.mesh;
    const NonmanifoldStats stats = split(cubes);
    EXPECT_EQ(stats.points_added, 0u);
    EXPECT_EQ(cubes.mesh.points, before.points);
    EXPECT_EQ(std::set<Cell>(cubes.mesh.cells.begin(), cubes.mesh.cells.end()),
              std::set<Cell>(before.cells.begin(), before.cells.end()));
}

TEST(SplitShapes, M08_two_cubes_that_share_an_edge) {
    Cubes cubes(6, [](int i, int j, int k) { return structure_if(k == 2 && i == j && (i == 2 || i == 3)); });
    EXPECT_EQ(cubes.topology(0).nonmanifold_edges, 1u);
    const NonmanifoldStats stats = split(cubes);
    EXPECT_GE(stats.edges_split, 1u);
    expect_manifold(cubes, 1);
    EXPECT_NEAR(cubes.volume(0), 2, 0.3);
}

TEST(SplitShapes, M08_two_cubes_that_share_a_corner) {
    Cubes cubes(6, [](int i, int j, int k) { return structure_if(i == j && j == k && (i == 2 || i == 3)); });
    EXPECT_EQ(cubes.topology(0).nonmanifold_edges, 0u);
    EXPECT_EQ(cubes.topology(0).nonmanifold_vertices, 1u);
    const NonmanifoldStats stats = split(cubes);
    EXPECT_EQ(stats.edges_split, 0u);
    EXPECT_EQ(stats.vertices_split, 1u);
    expect_manifold(cubes, 1);
    EXPECT_NEAR(cubes.volume(0), 2, 0.3);
}

// The corner stays on the surface of the structure whose contour passes through it.
TEST(SplitShapes, a_contour_vertex_at_the_shared_corner_stays_on_the_surface) {
    Cubes cubes(6, [](int i, int j, int k) { return structure_if(i == j && j == k && (i == 2 || i == 3)); });
    const auto corner = static_cast<std::uint32_t>(
        std::find(cubes.mesh.points.begin(), cubes.mesh.points.end(), Vec3{3, 3, 3}) -
        cubes.mesh.points.begin());
    split(cubes, ContourOwners({{corner, 0}}, cubes.mesh.points.size()));
    expect_manifold(cubes, 1);
    const auto surface = structure_surface(cubes.mesh, cubes.registry.table(), 0);
    EXPECT_TRUE(std::any_of(surface.begin(), surface.end(), [&](const Triangle& t) {
        return std::find(t.begin(), t.end(), corner) != t.end();
    }));
}

// The segments of contours that meet there too: what is cut off them at the corner goes on along them.
TEST(SplitShapes, contour_segments_at_the_shared_corner_stay_on_the_surface) {
    for (const std::uint32_t structures : {1u, 2u}) {
        SCOPED_TRACE(structures);
        Cubes cubes(6, [&](int i, int j, int k) {
            if (i != j || j != k || (i != 2 && i != 3)) return std::vector<std::uint32_t>{};
            return std::vector<std::uint32_t>{structures == 2 && i == 3 ? 1u : 0u};
        });
        const auto at = [&](Vec3 p) {
            return static_cast<std::uint32_t>(
                std::find(cubes.mesh.points.begin(), cubes.mesh.points.end(), p) - cubes.mesh.points.begin());
        };
        // The sides of both cubes in the plane of the corner.
        const std::uint32_t corner = at({3, 3, 3}), last = structures - 1;
        const std::vector<std::array<std::uint32_t, 3>> subsegments{{corner, at({2, 3, 3}), 0},
                                                                    {at({3, 2, 3}), corner, 0},
                                                                    {corner, at({4, 3, 3}), last},
                                                                    {at({3, 4, 3}), corner, last}};
        const NonmanifoldStats stats =
            split(cubes, ContourOwners({{corner, 0}, {corner, last}}, cubes.mesh.points.size(), subsegments));
        EXPECT_EQ(stats.vertices_split, 1u);
        EXPECT_EQ(stats.segments.vertices.size(), subsegments.size());
        expect_manifold(cubes, structures);
        for (const auto& [a, b, structure] : subsegments) {
            const Vec3 middle = 0.5 * (cubes.mesh.points[a] + cubes.mesh.points[b]);
            const std::uint32_t between = at(middle);
            EXPECT_NE(std::find(stats.segments.vertices.begin(), stats.segments.vertices.end(), between),
                      stats.segments.vertices.end());
            const auto surface = structure_surface(cubes.mesh, cubes.registry.table(), structure);
            for (const std::uint32_t end : {a, b}) {
                EXPECT_TRUE(std::any_of(surface.begin(), surface.end(), [&](const Triangle& t) {
                    return std::find(t.begin(), t.end(), end) != t.end() &&
                           std::find(t.begin(), t.end(), between) != t.end();
                }));
            }
        }
    }
}

TEST(SplitShapes, L15_checkerboard) {
    Cubes cubes(6, [](int i, int j, int k) { return structure_if((i + j + k) % 2 == 0); });
    split(cubes);
    expect_manifold(cubes, 1);
    EXPECT_NEAR(cubes.volume(0), 32, 16);
}

// Cells round an edge, in and out by turns, one of them so flat that a point half way along its edges may be
// rounded to its other side: a cell made there would lie over its neighbour, and facets no longer meet.
TEST(SplitShapes, cells_beside_a_nearly_flat_one_do_not_overlap) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> coordinate(-30, 30);
    const auto anywhere = [&] { return Vec3{coordinate(random), coordinate(random), coordinate(random)}; };
    int flat = 0, given = 0;
    for (int n = 0; n < 1000; ++n) {
        const double angle = std::pow(10.0, -(n % 18));  // of the flat one
        const Vec3 a = anywhere(), axis = normalized(anywhere()), u = normalized(cross(axis, anywhere())),
                   v = cross(axis, u);
        TetMesh mesh;
        mesh.points = {a, a + 0.3 * axis};
        const std::array<double, 6> angles{0, 0.5 * angle, 1, 2, 3.5, 5};
        for (std::size_t k = 0; k < angles.size(); ++k) {
            mesh.points.push_back(a + 0.1 * static_cast<double>(k) * axis +
                                  (1 + static_cast<double>(k)) *
                                      (std::cos(angles[k]) * u + std::sin(angles[k]) * v));
        }
        mesh.points.insert(mesh.points.end(), {a - 1.5 * axis, a + 1.8 * axis});
        for (std::uint32_t k = 0; k < 6; ++k) mesh.cells.push_back({0, 1, 2 + k, 2 + (k + 1) % 6});
        for (std::uint32_t k = 0; k < 6; ++k) {  // all round both ends
            mesh.cells.push_back({8, 0, 2 + k, 2 + (k + 1) % 6});
            mesh.cells.push_back({1, 9, 2 + k, 2 + (k + 1) % 6});
        }
        const std::vector<Vec3>& p = mesh.points;
        if (std::any_of(mesh.cells.begin(), mesh.cells.end(),
                        [&](const Cell& c) { return orient3d(p[c[0]], p[c[1]], p[c[2]], p[c[3]]) <= 0; }))
            continue;
        RegionRegistry registry;
        const Region in = registry.intern({0});
        mesh.regions = {in, 0, in, 0, in, 0};
        mesh.regions.resize(mesh.cells.size(), 0);
        const auto made = resolve_nonmanifold(mesh, {0, 1}, {}, registry, {});
        ASSERT_TRUE(made.ok()) << angle;
        if (angle > 1e-9) {
            EXPECT_EQ(made.value().components_relabelled, 0u) << angle;
        } else {
            ++flat;
            given += made.value().components_relabelled > 0;
        }
        std::map<std::array<std::uint32_t, 3>, int> sides;  // of facets, by their vertices in order
        for (const Cell& c : mesh.cells) {
            EXPECT_EQ(orient3d(p[c[0]], p[c[1]], p[c[2]], p[c[3]]), 1);
            for (std::array<std::uint32_t, 3> f :
                 {std::array{c[1], c[2], c[3]}, std::array{c[0], c[3], c[2]}, std::array{c[0], c[1], c[3]},
                  std::array{c[0], c[2], c[1]}}) {
                std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
                EXPECT_EQ(++sides[f], 1) << "two cells on one side of a facet";
            }
        }
    }
    EXPECT_GT(flat, 200);
    EXPECT_GT(given, 0) << "where no split has room, a piece goes to the other side";
    EXPECT_LT(given, flat);
}

TEST(SplitShapes, checkerboard_of_three_structures) {
    Cubes cubes(6, [](int i, int j, int k) {
        return std::vector<std::uint32_t>{static_cast<std::uint32_t>((i + 2 * j + 3 * k) % 3)};
    });
    split(cubes);
    expect_manifold(cubes, 3);
}

// Old vertices stay; what is far from the singular places keeps its cells and regions.
TEST(SplitShapes, touches_nothing_elsewhere) {
    Cubes cubes(9, [](int i, int j, int k) { return structure_if(k == 2 && i == j && (i == 2 || i == 3)); });
    const TetMesh before = cubes.mesh;
    split(cubes);
    ASSERT_GE(cubes.mesh.points.size(), before.points.size());
    EXPECT_TRUE(std::equal(before.points.begin(), before.points.end(), cubes.mesh.points.begin()));
    std::set<std::pair<Cell, Region>> after;
    for (std::size_t c = 0; c < cubes.mesh.cells.size(); ++c)
        after.emplace(cubes.mesh.cells[c], cubes.mesh.regions[c]);
    for (std::size_t c = 0; c < before.cells.size(); ++c) {
        bool near = false;
        for (const std::uint32_t v : before.cells[c])
            near = near || length(before.points[v] - Vec3{3, 3, 2.5}) < 1.5;
        if (near) continue;
        ASSERT_EQ(after.count({before.cells[c], before.regions[c]}), 1u);
    }
}

TEST(SplitShapes, relabelling_lessens_the_unsound_vertices_and_is_deterministic) {
    for (std::uint32_t seed = 1; seed <= 5; ++seed) {
        const auto make = [&] {
            std::mt19937 random(seed);
            return Cubes(7, [&](int, int, int) { return structure_if(random() % 2 == 0); });
        };
        Cubes one = make(), two = make();
        for (Cubes* cubes : {&one, &two}) {
            const VertexStars stars(cubes->mesh.cells, cubes->mesh.points.size());
            std::vector<std::uint32_t> nonmanifold;
            const RelabelStats stats = relabel({cubes->mesh.points,
                                                cubes->mesh.cells,
                                                cubes->neighbors,
                                                stars,
                                                {},
                                                {},
                                                cubes->mesh.regions,
                                                cubes->registry},
                                               {}, nonmanifold);
            EXPECT_LT(stats.nonmanifold_after, stats.nonmanifold_before);
            EXPECT_EQ(nonmanifold.size(), stats.nonmanifold_after);
            EXPECT_TRUE(std::is_sorted(nonmanifold.begin(), nonmanifold.end()));
        }
        EXPECT_EQ(one.mesh.regions, two.mesh.regions);
        split(one);
        expect_manifold(one, 1);
        split(two);
        EXPECT_EQ(one.mesh.cells, two.mesh.cells);
        EXPECT_EQ(one.mesh.points, two.mesh.points);
    }
}

}  // namespace
}  // namespace anatomesh::split_shapes_test
