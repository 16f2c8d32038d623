#include "anatomesh/mesh/check/topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh::topology_test {
namespace {

using testing::brick_mesh;

const RegionTable one_structure{{{}, {0}}};

Region everywhere(int, int, int) {
    return 1;
}

SurfaceTopology topology_of(const TetMesh& mesh) {
    return surface_topology(structure_surface(mesh, one_structure, 0));
}

TEST(Topology, neighbors_are_mutual_and_share_the_facet) {
    const TetMesh mesh = brick_mesh({4, 3, 5}, everywhere);
    const auto neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    std::size_t boundary = 0;
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        for (std::uint32_t i = 0; i < 4; ++i) {
            const std::uint32_t other = neighbors[4 * c + i];
            if (other == no_cell) {
                ++boundary;
                continue;
            }
            const Cell& theirs = mesh.cells[other];
            EXPECT_EQ(std::count(&neighbors[4 * other], &neighbors[4 * other] + 4, c), 1);
            for (std::uint32_t v = 0; v < 4; ++v) {
                const auto found = std::find(theirs.begin(), theirs.end(), mesh.cells[c][v]);
                EXPECT_EQ(found != theirs.end(), v != i);
            }
        }
    }
    EXPECT_EQ(boundary, 2u * 2u * (4 * 3 + 3 * 5 + 5 * 4));
}

TEST(Topology, ball_torus_shell_and_two_balls_have_their_genus_and_components) {
    const SurfaceTopology ball = topology_of(brick_mesh({3, 3, 3}, everywhere));
    EXPECT_TRUE(ball.closed_manifold());
    EXPECT_EQ(ball.components, 1u);
    EXPECT_EQ(ball.euler, 2);
    EXPECT_EQ(ball.genus, 0);
    EXPECT_EQ(ball.triangles, 2u * 54u);
    EXPECT_EQ(ball.edges, 3u * 54u);

    const auto frame = [](int i, int j, int) { return Region(i == 1 && j == 1 ? 0 : 1); };
    const SurfaceTopology torus = topology_of(brick_mesh({3, 3, 1}, frame));
    EXPECT_TRUE(torus.closed_manifold());
    EXPECT_EQ(torus.components, 1u);
    EXPECT_EQ(torus.genus, 1);

    const auto two_holes = [](int i, int j, int) { return Region((i == 1 || i == 3) && j == 1 ? 0 : 1); };
    EXPECT_EQ(topology_of(brick_mesh({5, 3, 1}, two_holes)).genus, 2);

    const auto hollow = [](int i, int j, int k) { return Region(i == 1 && j == 1 && k == 1 ? 0 : 1); };
    const SurfaceTopology shell = topology_of(brick_mesh({3, 3, 3}, hollow));
    EXPECT_TRUE(shell.closed_manifold());
    EXPECT_EQ(shell.components, 2u);
    EXPECT_EQ(shell.genus, 0);

    const auto apart = [](int i, int, int) { return Region(i == 1 ? 0 : 1); };
    const TetMesh two = brick_mesh({3, 1, 1}, apart);
    EXPECT_EQ(topology_of(two).components, 2u);
    EXPECT_EQ(structure_pieces(two, one_structure, 0), 2u);
}

TEST(Topology, touching_at_an_edge_or_a_vertex_is_counted) {
    const auto at_edge = [](int i, int j, int) { return Region(i == j ? 1 : 0); };
    const TetMesh edge = brick_mesh({2, 2, 1}, at_edge);
    EXPECT_EQ(topology_of(edge).nonmanifold_edges, 1u);
    EXPECT_EQ(topology_of(edge).open_edges, 0u);
    EXPECT_EQ(structure_pieces(edge, one_structure, 0), 2u);

    const auto at_vertex = [](int i, int j, int k) { return Region(i == j && j == k ? 1 : 0); };
    const SurfaceTopology vertex = topology_of(brick_mesh({2, 2, 2}, at_vertex));
    EXPECT_EQ(vertex.nonmanifold_edges, 0u);
    EXPECT_EQ(vertex.nonmanifold_vertices, 1u);
    EXPECT_EQ(vertex.components, 2u);
    EXPECT_FALSE(vertex.closed_manifold());
}

TEST(Topology, a_hole_and_a_turned_triangle_are_counted) {
    std::vector<Triangle> surface = structure_surface(brick_mesh({2, 2, 2}, everywhere), one_structure, 0);
    std::swap(surface[5][0], surface[5][1]);
    EXPECT_EQ(surface_topology(surface).misoriented_edges, 3u);
    surface.erase(surface.begin() + 5);
    EXPECT_EQ(surface_topology(surface).open_edges, 3u);
    EXPECT_EQ(surface_topology(surface).misoriented_edges, 0u);
    EXPECT_EQ(surface_topology({}).components, 0u);
    EXPECT_EQ(surface_topology({}).genus, 0);
}

TEST(Topology, every_count_is_the_same_for_shuffled_triangles) {
    const auto pattern = [](int i, int j, int k) { return Region((i * 7 + j * 5 + k * 3) % 4 != 0); };
    std::vector<Triangle> surface = structure_surface(brick_mesh({6, 6, 6}, pattern), one_structure, 0);
    const SurfaceTopology before = surface_topology(surface);
    EXPECT_GT(before.nonmanifold_edges, 0u);
    std::shuffle(surface.begin(), surface.end(), std::mt19937(7));
    const SurfaceTopology after = surface_topology(surface);
    EXPECT_EQ(before.edges, after.edges);
    EXPECT_EQ(before.components, after.components);
    EXPECT_EQ(before.nonmanifold_edges, after.nonmanifold_edges);
    EXPECT_EQ(before.nonmanifold_vertices, after.nonmanifold_vertices);
}

TEST(Topology, interfaces_hold_every_facet_once_and_enclose_the_volumes) {
    const auto halves = [](int i, int, int) { return Region(i < 2 ? 1 : 3); };
    const TetMesh mesh = brick_mesh({4, 3, 2}, halves);
    const SurfaceMesh surface = extract_interfaces(mesh);
    ASSERT_EQ(surface.triangles.size(), surface.sides.size());
    EXPECT_EQ(surface.triangles.size(), 2u * (2 * (4 * 3 + 3 * 2 + 2 * 4) + 3 * 2));
    std::array<double, 4> volume{};
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const auto [inner, outer] = surface.sides[t];
        EXPECT_GT(inner, outer);
        const Triangle& f = surface.triangles[t];
        const double part =
            signed_volume({}, surface.points[f[0]], surface.points[f[1]], surface.points[f[2]]);
        volume[inner] += part;
        volume[outer] -= part;
    }
    EXPECT_DOUBLE_EQ(volume[1], 12.0);
    EXPECT_DOUBLE_EQ(volume[3], 12.0);
    EXPECT_DOUBLE_EQ(volume[0], -24.0);
}

TEST(Topology, a_structure_is_the_union_of_its_regions) {
    const auto thirds = [](int i, int, int) { return Region(i + 1); };
    const TetMesh mesh = brick_mesh({3, 1, 1}, thirds);
    const RegionTable overlapping{{{}, {0}, {0, 1}, {1}}};
    for (const std::uint32_t structure : {0u, 1u}) {
        const auto surface = structure_surface(mesh, overlapping, structure);
        EXPECT_EQ(surface.size(), 2u * 10u);
        EXPECT_TRUE(surface_topology(surface).closed_manifold());
        EXPECT_EQ(structure_pieces(mesh, overlapping, structure), 1u);
    }
}

TEST(Topology, is_fast_enough_to_run_after_every_round) {
    const TetMesh mesh = brick_mesh({37, 37, 37}, everywhere);
    const auto start = std::chrono::steady_clock::now();
    const auto neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    const auto spread = [](int i, int j, int k) { return Region((i + j + k) % 2); };
    const auto surface = structure_surface(brick_mesh({26, 26, 26}, spread), one_structure, 0);
    const auto second = std::chrono::steady_clock::now();
    const SurfaceTopology topology = surface_topology(surface);
    const std::chrono::duration<double, std::milli> surface_took = std::chrono::steady_clock::now() - second;
    RecordProperty("neighbors_ms", std::to_string(took.count()));
    RecordProperty("surface_ms", std::to_string(surface_took.count()));
    EXPECT_EQ(neighbors.size(), 4 * mesh.cells.size());
    EXPECT_GT(topology.triangles, 100'000u);
    // Ten times the figures aimed at, for slow and instrumented builds.
    EXPECT_LT(took.count(), 3000.0) << mesh.cells.size() << " cells";
    EXPECT_LT(surface_took.count(), 2000.0) << topology.triangles << " triangles";
}

// Against the neighbours of all cells.
TEST(RegionFacets, are_those_between_cells_of_two_regions) {
    std::vector<Vec3> points;
    std::vector<Cell> cells;
    constexpr std::uint32_t n = 6;
    for (std::uint32_t k = 0; k <= n; ++k) {
        for (std::uint32_t j = 0; j <= n; ++j) {
            for (std::uint32_t i = 0; i <= n; ++i) points.push_back({double(i), double(j), double(k)});
        }
    }
    // Six cells round the diagonal of every cube.
    const auto at = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
        return (k * (n + 1) + j) * (n + 1) + i;
    };
    const std::array<std::array<std::uint32_t, 3>, 6> ways{
        {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
    for (std::uint32_t k = 0; k < n; ++k) {
        for (std::uint32_t j = 0; j < n; ++j) {
            for (std::uint32_t i = 0; i < n; ++i) {
                for (std::size_t w = 0; w < 6; ++w) {
                    std::array<std::uint32_t, 3> step{i, j, k};
                    Cell cell{at(i, j, k), 0, 0, at(i + 1, j + 1, k + 1)};
                    for (std::size_t s = 0; s < 2; ++s) {
                        ++step[ways[w][s]];
                        cell[s + 1] = at(step[0], step[1], step[2]);
                    }
                    if (w >= 3) std::swap(cell[1], cell[2]);
                    cells.push_back(cell);
                }
            }
        }
    }
    const std::vector<std::uint32_t> neighbors = cell_neighbors(cells, points.size());
    // With cells outside all round, and without any.
    for (const bool ends : {false, true}) {
        TetMesh mesh{points, cells, {}};
        for (std::uint32_t c = 0; c < cells.size(); ++c) {
            const bool inner = std::all_of(cells[c].begin(), cells[c].end(), [&](std::uint32_t v) {
                const Vec3 p = points[v];
                return std::min({p.x, p.y, p.z}) > 0 && std::max({p.x, p.y, p.z}) < n;
            });
            const std::uint32_t drawn = (c * 2654435761u >> 16) % 40 / 37;
            mesh.regions.push_back(static_cast<Region>(ends ? 1 + drawn : inner ? drawn : 0));
        }
        std::map<std::set<std::uint32_t>, std::vector<std::uint32_t>> sides;  // the facets of three vertices
        for (std::uint32_t f = 0; f < 4 * cells.size(); ++f) {
            std::set<std::uint32_t> corners(cells[f / 4].begin(), cells[f / 4].end());
            corners.erase(cells[f / 4][f % 4]);
            sides[corners].push_back(f);
        }
        std::vector<std::array<std::uint32_t, 3>> expected;
        for (const auto& [corners, facets] : sides) {
            for (const std::uint32_t f : facets) {
                const std::uint32_t other =
                    facets.size() == 1 ? no_cell : (facets[0] == f ? facets[1] : facets[0]) / 4;
                const Region beyond = other == no_cell ? Region{0} : mesh.regions[other];
                if (mesh.regions[f / 4] > beyond) expected.push_back({f / 4, f % 4, other});
            }
        }
        std::sort(expected.begin(), expected.end());
        EXPECT_GT(expected.size(), 20u);
        std::vector<std::array<std::uint32_t, 3>> found;
        for (const RegionFacet& f : region_facets(mesh, neighbors))
            found.push_back({f.cell, f.index, f.other});
        EXPECT_EQ(found, expected);
        for (const int threads : {2, 3}) EXPECT_EQ(cell_neighbors(cells, points.size(), threads), neighbors);
    }
}

}  // namespace
}  // namespace anatomesh::topology_test
