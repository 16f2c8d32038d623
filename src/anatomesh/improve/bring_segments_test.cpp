#include "anatomesh/improve/bring_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <random>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/mesh/brick_mesh_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh {
namespace {

using Piece = std::array<std::uint32_t, 3>;

constexpr double any_shape = 1e-4;

// What a test does with the cells that a sheet changed; returns those that it made.
using Improver =
    std::function<std::vector<std::uint32_t>(Workbench& bench, const std::vector<std::uint32_t>& cells)>;

// Cubes, some of them of a structure; grid points may be shaken.
struct Bricks {
    TetMesh mesh;
    RegionTable table{{{}, {0}}};
    std::vector<std::uint32_t> neighbors;
    std::vector<Vec3> grid;
    std::vector<Piece> pieces;
    std::vector<std::array<std::uint32_t, 2>> owned;

    explicit Bricks(const std::function<bool(Vec3)>& inside, double shaken = 0, unsigned seed = 1) {
        std::mt19937 random(seed);
        const auto shift = [&] { return shaken * (random() / 2147483648.0 - 1); };
        mesh = testing::brick_mesh({8, 8, 6}, [](int, int, int) { return Region{1}; });
        grid = mesh.points;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            Vec3 centre;
            for (const std::uint32_t v : mesh.cells[c]) centre += 0.25 * mesh.points[v];
            mesh.regions[c] = inside(centre) ? 1 : 0;
        }
        for (Vec3& p : mesh.points) p = p + Vec3{shift(), shift(), shift()};
        neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    }

    // Of a structure as it is.
    explicit Bricks(fixtures::LabelledCase labelled)
        : mesh(std::move(labelled.mesh)),
          table(std::move(labelled.regions)),
          neighbors(cell_neighbors(mesh.cells, mesh.points.size())),
          grid(mesh.points) {}

    // With both ends on the surface, and cells on one side of it alone.
    std::vector<std::array<std::uint32_t, 2>> edges_beside_surface() const {
        std::vector<std::array<std::uint32_t, 2>> edges[2];
        std::vector<std::uint32_t> vertices[2];
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const auto side = static_cast<std::size_t>(mesh.regions[c] != 0);
            const Cell& cell = mesh.cells[c];
            vertices[side].insert(vertices[side].end(), cell.begin(), cell.end());
            for (const auto& [i, j] : cell_edges)
                edges[side].push_back({std::min(cell[i], cell[j]), std::max(cell[i], cell[j])});
        }
        std::vector<std::uint32_t> both;
        std::vector<std::array<std::uint32_t, 2>> beside;
        for (std::size_t side = 0; side < 2; ++side) {
            sort_distinct(vertices[side]);
            sort_distinct(edges[side]);
        }
        std::set_intersection(vertices[0].begin(), vertices[0].end(), vertices[1].begin(), vertices[1].end(),
                              std::back_inserter(both));
        std::set_symmetric_difference(edges[0].begin(), edges[0].end(), edges[1].begin(), edges[1].end(),
                                      std::back_inserter(beside));
        std::erase_if(beside, [&](const auto& edge) {
            return !std::binary_search(both.begin(), both.end(), edge[0]) ||
                   !std::binary_search(both.begin(), both.end(), edge[1]);
        });
        return beside;
    }

    void draw(const std::vector<Vec3>& line) {
        std::vector<std::uint32_t> vertices;
        for (const Vec3 p : line)
            vertices.push_back(
                static_cast<std::uint32_t>(std::find(grid.begin(), grid.end(), p) - grid.begin()));
        owned.push_back({vertices.front(), 0});
        owned.push_back({vertices.back(), 0});
        for (std::size_t n = 1; n < vertices.size(); ++n) pieces.push_back({vertices[n - 1], vertices[n], 0});
    }

    BringStats bring(
        double least_sine = any_shape,
        const Improver& improve = [](Workbench&, const auto&) { return std::vector<std::uint32_t>{}; }) {
        const ContourOwners owners(owned, mesh.points.size(), pieces);
        std::vector<std::uint8_t> fixed(mesh.points.size(), 1);
        const fixtures::AnalyticField field({[](Vec3) { return 1.0; }}, 10);
        EditMesh edited(std::move(mesh), neighbors);
        DihedralOptions options;
        if (least_sine == any_shape) options.max_radius_edge = options.last_radius_edge = 1000;
        Workbench bench(edited, fixed, {}, field, 1, options);
        bench.table = &table;
        DrawnSlices drawn;
        drawn.table = &table;
        drawn.owners = &owners;
        drawn.pieces_beside = pieces;
        const BringStats stats =
            bring_segments(bench, drawn, least_sine,
                           [&](const std::vector<std::uint32_t>& cells) { return improve(bench, cells); });
        mesh = std::move(edited).take(neighbors);
        return stats;
    }

    bool on_surface(const Piece& piece) const {
        bool in = false, out = false;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const Cell& cell = mesh.cells[c];
            const auto has = [&](std::uint32_t v) {
                return std::find(cell.begin(), cell.end(), v) != cell.end();
            };
            if (has(piece[0]) && has(piece[1])) (mesh.regions[c] ? in : out) = true;
        }
        return in && out;
    }
};

bool in_block(Vec3 p) {
    return p.x > 1 && p.x < 7 && p.y > 1 && p.y < 7 && p.z > 1 && p.z < 4;
}
bool beside_trench(Vec3 p) {
    return p.x > 1 && p.x < 7 && p.y > 1 && p.y < 7 && p.z > 1 && p.z < 5 && !(p.x > 2 && p.x < 5 && p.z > 2);
}

void expect_brought(Bricks& bricks) {
    const TetMesh before = bricks.mesh;
    for (const Piece& piece : bricks.pieces) ASSERT_FALSE(bricks.on_surface(piece));
    const BringStats stats = bricks.bring();
    EXPECT_EQ(stats.found, bricks.pieces.size());
    EXPECT_EQ(stats.brought, bricks.pieces.size());
    for (const Piece& piece : bricks.pieces) EXPECT_TRUE(bricks.on_surface(piece));
    EXPECT_TRUE(std::equal(before.points.begin(), before.points.end(), bricks.mesh.points.begin()));
    EXPECT_EQ(bricks.neighbors, cell_neighbors(bricks.mesh.cells, bricks.mesh.points.size()));
    fixtures::expect_sound_mesh(bricks.mesh, before);
    fixtures::expect_same_surfaces(bricks.mesh, before, bricks.table, 1);
    fixtures::expect_sound_regions(bricks.mesh, bricks.table);
}

// An edge across the corner of a block, within it.
TEST(BringSegments, a_slit_is_cut_to_a_piece_under_the_surface) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(in_block, seed ? 0.15 : 0, seed);
        bricks.draw({{1, 4, 3}, {2, 4, 4}});
        expect_brought(bricks);
    }
}

// An edge from the floor of a trench to its wall.
TEST(BringSegments, a_fin_is_built_to_a_piece_over_the_surface) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(beside_trench, seed ? 0.15 : 0, seed);
        bricks.draw({{4, 4, 2}, {5, 4, 3}});
        expect_brought(bricks);
    }
}

TEST(BringSegments, pieces_with_a_vertex_under_the_surface_between_them_come_together) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(in_block, seed ? 0.1 : 0, seed);
        bricks.draw({{1, 4, 2}, {2, 4, 3}, {3, 4, 4}});
        expect_brought(bricks);
    }
}

TEST(BringSegments, pieces_near_each_other_are_brought_without_losing_one) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(in_block, seed ? 0.1 : 0, seed);
        for (int y = 2; y < 7; ++y) bricks.draw({{1, 1.0 * y, 3}, {2, 1.0 * y, 4}});
        expect_brought(bricks);
    }
}

// Puts a vertex at this share of the way from a to b, if that is a fixed edge.
std::vector<std::uint32_t> split_fixed_edge(Workbench& bench, std::uint32_t a, std::uint32_t b,
                                            double share) {
    if (!bench.fixed_edge(a, b)) return {};
    bench.mesh.star(a, bench.star);
    for (const std::uint32_t c : bench.star) {
        for (int e = 0; e < 6; ++e) {
            const Cell& cell = bench.mesh.cell(c);
            if (std::minmax(cell[cell_edges[e][0]], cell[cell_edges[e][1]]) != std::minmax(a, b)) continue;
            bench.mesh.ring(c, e, bench.ring);
            const Vec3 from = bench.mesh.point(a);
            const std::uint32_t v = bench.add_point(from + share * (bench.mesh.point(b) - from));
            std::vector<Cell> cells;
            std::vector<Region> regions;
            for (const std::uint32_t round : bench.ring.cells) {
                for (const std::uint32_t end : {a, b}) {
                    cells.push_back(bench.mesh.cell(round));
                    std::replace(cells.back().begin(), cells.back().end(), end, v);
                    regions.push_back(bench.mesh.region(round));
                }
            }
            if (!bench.commit(bench.ring.cells, cells, regions)) return {};
            bench.fix_on_edge(v, a, b);
            return bench.changed;
        }
    }
    return {};
}

// Operations put vertices on fixed edges, and on the halves again.
TEST(BringSegments, a_piece_that_improvement_splits_is_brought) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(in_block, seed ? 0.1 : 0, seed);
        bricks.draw({{1, 4, 2}, {2, 4, 3}, {3, 4, 4}});
        const TetMesh before = bricks.mesh;
        const double share = 0.3 + 0.04 * seed;
        const BringStats stats = bricks.bring(any_shape, [&](Workbench& bench, const auto&) {
            std::vector<std::uint32_t> made;
            for (const Piece& piece : bricks.pieces) {
                const auto middle = static_cast<std::uint32_t>(bench.mesh.point_count());
                made = split_fixed_edge(bench, piece[0], piece[1], share);
                EXPECT_FALSE(made.empty());
                made = split_fixed_edge(bench, middle, piece[1], share);
                EXPECT_FALSE(made.empty());
            }
            return made;
        });
        EXPECT_EQ(stats.found, 2u);
        EXPECT_EQ(stats.brought, 2u);
        fixtures::expect_same_surfaces(bricks.mesh, before, bricks.table, 1);
    }
}

// Cells that nothing improves are not accepted, and then all is as it was.
TEST(BringSegments, what_would_leave_bad_cells_is_taken_back) {
    Bricks bricks(beside_trench);
    bricks.draw({{4, 4, 2}, {5, 4, 3}});
    const TetMesh before = bricks.mesh;
    const std::vector<std::uint32_t> neighbors = bricks.neighbors;
    const BringStats stats = bricks.bring(0.9);
    EXPECT_EQ(stats.found, 1u);
    EXPECT_EQ(stats.brought, 0u);
    EXPECT_EQ(bricks.mesh.cells, before.cells);
    EXPECT_EQ(bricks.mesh.regions, before.regions);
    EXPECT_EQ(bricks.neighbors, neighbors);
    EXPECT_TRUE(std::equal(before.points.begin(), before.points.end(), bricks.mesh.points.begin()));
}

TEST(BringSegments, a_piece_on_the_surface_stays_as_it_is) {
    Bricks bricks(in_block);
    bricks.draw({{1, 4, 3}, {1, 4, 4}});
    const TetMesh before = bricks.mesh;
    EXPECT_EQ(bricks.bring().found, 0u);
    EXPECT_EQ(bricks.mesh.cells, before.cells);
    EXPECT_EQ(bricks.mesh.regions, before.regions);
}

// The sheets bend along a surface of random facets: at a vertex of it they part the cells on their side.
TEST(BringSegments, an_edge_from_surface_to_surface_is_brought_whatever_cells_there_are) {
    constexpr std::size_t every = 10;
    for (std::uint32_t seed = 1; seed <= 2; ++seed) {
        const Bricks ball(
            fixtures::random_case("ball", fixtures::AnalyticField({fixtures::ball({}, 7)}, 9), 1, seed));
        const auto edges = ball.edges_beside_surface();
        ASSERT_GT(edges.size(), 500u);
        for (std::size_t n = every / 2; n < edges.size(); n += every) {
            SCOPED_TRACE(n);
            Bricks bricks = ball;
            bricks.draw({ball.grid[edges[n][0]], ball.grid[edges[n][1]]});
            expect_brought(bricks);
        }
    }
}

}  // namespace
}  // namespace anatomesh
