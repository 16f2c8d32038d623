#include "anatomesh/improve/surgery/recover_on_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <random>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::recover_on_surface_test {
namespace {

using Subsegment = std::array<std::uint32_t, 3>;

constexpr double any_shape = 1e-4, any_ratio = 1000;
constexpr double least_within = 0.8;
constexpr double least_recovered = 0.95;  // share, where membranes may be in each other's way

// What a test does with the cells that a membrane changed; returns those that it made.
using Improver =
    std::function<std::vector<std::uint32_t>(EditContext& edit, const std::vector<std::uint32_t>& cells)>;

// Cubes, some of them of a structure; grid points may be shaken.
struct Bricks {
    TetMesh mesh;
    RegionTable table{{{}, {0}}};
    std::vector<std::uint32_t> neighbors;
    std::vector<Vec3> grid;
    std::vector<Subsegment> subsegments;
    std::vector<std::array<std::uint32_t, 2>> owned;
    double max_radius_edge = any_ratio, most_more_share = 0;  // as recover_on_surface() has them

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

    bool inside(std::size_t c) const { return table.contains(mesh.regions[c], 0); }

    // With both ends on the first structure's surface, and cells on one side of it alone.
    std::vector<std::array<std::uint32_t, 2>> edges_beside_surface() const {
        std::vector<std::array<std::uint32_t, 2>> edges[2];
        std::vector<std::uint32_t> vertices[2];
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const auto side = static_cast<std::size_t>(inside(c));
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

    bool has_facet(const std::array<std::uint32_t, 3>& facet) const {
        return std::any_of(mesh.cells.begin(), mesh.cells.end(), [&](const Cell& cell) {
            return std::all_of(facet.begin(), facet.end(), [&](std::uint32_t v) {
                return std::find(cell.begin(), cell.end(), v) != cell.end();
            });
        });
    }

    // Whether all cells at a vertex are on this side of the first structure.
    bool lies(bool in, std::uint32_t v) const {
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const Cell& cell = mesh.cells[c];
            if (inside(c) != in && std::find(cell.begin(), cell.end(), v) != cell.end()) return false;
        }
        return true;
    }

    // By edges of the first structure's surface.
    std::vector<std::uint32_t> joined_on_surface(std::uint32_t v) const {
        std::vector<std::uint32_t> joined;
        for (const Triangle& facet : structure_surface(mesh, table, 0)) {
            if (std::find(facet.begin(), facet.end(), v) != facet.end())
                joined.insert(joined.end(), facet.begin(), facet.end());
        }
        sort_distinct(joined);
        std::erase(joined, v);
        return joined;
    }

    // Puts a vertex in the middle of a facet, whose two cells become six.
    std::uint32_t split_facet(const std::array<std::uint32_t, 3>& facet) {
        const auto middle = static_cast<std::uint32_t>(mesh.points.size());
        Vec3 p{};
        for (const std::uint32_t v : facet) p = p + (1.0 / 3) * mesh.points[v];
        mesh.points.push_back(p);
        grid.push_back(p);
        const std::size_t count = mesh.cells.size();
        for (std::size_t c = 0; c < count; ++c) {
            const Cell cell = mesh.cells[c];
            const auto has = [&](std::uint32_t v) {
                return std::find(cell.begin(), cell.end(), v) != cell.end();
            };
            if (!std::all_of(facet.begin(), facet.end(), has)) continue;
            std::replace(mesh.cells[c].begin(), mesh.cells[c].end(), facet[0], middle);
            for (const std::uint32_t v : {facet[1], facet[2]}) {
                mesh.cells.push_back(cell);
                std::replace(mesh.cells.back().begin(), mesh.cells.back().end(), v, middle);
                mesh.regions.push_back(mesh.regions[c]);
            }
        }
        neighbors = cell_neighbors(mesh.cells, mesh.points.size());
        return middle;
    }

    void draw(const std::vector<Vec3>& line) {
        std::vector<std::uint32_t> vertices;
        for (const Vec3 p : line)
            vertices.push_back(
                static_cast<std::uint32_t>(std::find(grid.begin(), grid.end(), p) - grid.begin()));
        owned.push_back({vertices.front(), 0});
        owned.push_back({vertices.back(), 0});
        for (std::size_t n = 1; n < vertices.size(); ++n)
            subsegments.push_back({vertices[n - 1], vertices[n], 0});
    }

    SurfaceRecoveryStats recover(
        double least_sine = any_shape,
        const Improver& improve = [](EditContext&, const auto&) { return std::vector<std::uint32_t>{}; }) {
        const ContourOwners owners(owned, mesh.points.size(), subsegments);
        std::vector<std::uint8_t> fixed(mesh.points.size(), 1);
        const fixtures::AnalyticField field({2, [](Vec3) { return 1.0; }}, 10);
        EditMesh edited(std::move(mesh), neighbors);
        MeshImprovementOptions options;
        if (least_sine == any_shape) {
            options.max_radius_edge = max_radius_edge;
            options.last_radius_edge = any_ratio;
        }
        EditContext edit(edited, fixed, {}, field, 1, options);
        edit.table = &table;
        DrawnSlices drawn;
        drawn.table = &table;
        drawn.owners = &owners;
        drawn.subsegments_beside = subsegments;
        const SurfaceRecoveryStats stats =
            recover_on_surface(edit, drawn, least_sine, most_more_share,
                               [&](const std::vector<std::uint32_t>& cells) { return improve(edit, cells); });
        mesh = std::move(edited).take(neighbors);
        return stats;
    }

    bool on_surface(const Subsegment& subsegment) const {
        bool in = false, out = false;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const Cell& cell = mesh.cells[c];
            const auto has = [&](std::uint32_t v) {
                return std::find(cell.begin(), cell.end(), v) != cell.end();
            };
            if (has(subsegment[0]) && has(subsegment[1])) (inside(c) ? in : out) = true;
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

// Whether all subsegments were recovered that were off the surface; the others stay, and the surfaces are
// what they were.
bool recovers_all(Bricks& bricks, std::uint32_t structures = 1) {
    const TetMesh before = bricks.mesh;
    const auto off_surface = [&] {
        return static_cast<std::size_t>(
            std::count_if(bricks.subsegments.begin(), bricks.subsegments.end(),
                          [&](const Subsegment& subsegment) { return !bricks.on_surface(subsegment); }));
    };
    const std::size_t off_before = off_surface();
    const SurfaceRecoveryStats stats = bricks.recover();
    EXPECT_EQ(stats.found, off_before);
    EXPECT_EQ(off_surface(), stats.found - stats.recovered);
    EXPECT_TRUE(std::equal(before.points.begin(), before.points.end(), bricks.mesh.points.begin()));
    EXPECT_EQ(bricks.neighbors, cell_neighbors(bricks.mesh.cells, bricks.mesh.points.size()));
    fixtures::expect_sound_mesh(bricks.mesh, before);
    fixtures::expect_same_surfaces(bricks.mesh, before, bricks.table, structures);
    fixtures::expect_sound_regions(bricks.mesh, bricks.table);
    return stats.recovered == off_before;
}

void expect_recovered(Bricks& bricks) {
    for (const Subsegment& subsegment : bricks.subsegments) ASSERT_FALSE(bricks.on_surface(subsegment));
    EXPECT_TRUE(recovers_all(bricks));
}

// An edge across the corner of a block, within it.
TEST(RecoverOnSurface, a_slit_is_cut_to_a_subsegment_under_the_surface) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(in_block, seed ? 0.15 : 0, seed);
        bricks.draw({{1, 4, 3}, {2, 4, 4}});
        expect_recovered(bricks);
    }
}

// An edge from the floor of a trench to its wall.
TEST(RecoverOnSurface, a_fin_is_built_to_a_subsegment_over_the_surface) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(beside_trench, seed ? 0.15 : 0, seed);
        bricks.draw({{4, 4, 2}, {5, 4, 3}});
        expect_recovered(bricks);
    }
}

TEST(RecoverOnSurface, subsegments_with_a_vertex_under_the_surface_between_them_come_together) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(in_block, seed ? 0.1 : 0, seed);
        bricks.draw({{1, 4, 2}, {2, 4, 3}, {3, 4, 4}});
        expect_recovered(bricks);
    }
}

TEST(RecoverOnSurface, subsegments_near_each_other_are_recovered_without_losing_one) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(in_block, seed ? 0.1 : 0, seed);
        for (int y = 2; y < 7; ++y) bricks.draw({{1, 1.0 * y, 3}, {2, 1.0 * y, 4}});
        expect_recovered(bricks);
    }
}

// Puts a vertex at this share of the way from a to b, if that is a fixed edge.
std::vector<std::uint32_t> split_fixed_edge(EditContext& edit, std::uint32_t a, std::uint32_t b,
                                            double share) {
    if (!edit.constraints.fixed_edge(a, b)) return {};
    edit.mesh.star(a, edit.star);
    for (const std::uint32_t c : edit.star) {
        for (int e = 0; e < 6; ++e) {
            const Cell& cell = edit.mesh.cell(c);
            if (std::minmax(cell[cell_edges[e][0]], cell[cell_edges[e][1]]) != std::minmax(a, b)) continue;
            edit.mesh.ring(c, e, edit.ring);
            const Vec3 from = edit.mesh.point(a);
            const std::uint32_t v = edit.add_point(from + share * (edit.mesh.point(b) - from));
            std::vector<Cell> cells;
            std::vector<Region> regions;
            for (const std::uint32_t round : edit.ring.cells) {
                for (const std::uint32_t end : {a, b}) {
                    cells.push_back(edit.mesh.cell(round));
                    std::replace(cells.back().begin(), cells.back().end(), end, v);
                    regions.push_back(edit.mesh.region(round));
                }
            }
            if (!edit.commit(edit.ring.cells, cells, regions)) return {};
            edit.fix_on_edge(v, a, b);
            return edit.changed;
        }
    }
    return {};
}

// Operations put vertices on fixed edges, and on the halves again.
TEST(RecoverOnSurface, a_subsegment_that_improvement_splits_is_recovered) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Bricks bricks(in_block, seed ? 0.1 : 0, seed);
        bricks.draw({{1, 4, 2}, {2, 4, 3}, {3, 4, 4}});
        const TetMesh before = bricks.mesh;
        const double share = 0.3 + 0.04 * seed;
        const SurfaceRecoveryStats stats = bricks.recover(any_shape, [&](EditContext& edit, const auto&) {
            std::vector<std::uint32_t> made;
            for (const Subsegment& subsegment : bricks.subsegments) {
                const auto middle = static_cast<std::uint32_t>(edit.mesh.point_count());
                made = split_fixed_edge(edit, subsegment[0], subsegment[1], share);
                EXPECT_FALSE(made.empty());
                made = split_fixed_edge(edit, middle, subsegment[1], share);
                EXPECT_FALSE(made.empty());
            }
            return made;
        });
        EXPECT_EQ(stats.found, 2u);
        EXPECT_EQ(stats.recovered, 2u);
        fixtures::expect_same_surfaces(bricks.mesh, before, bricks.table, 1);
    }
}

// Cells that nothing improves are not accepted, and then all is as it was.
TEST(RecoverOnSurface, what_would_leave_bad_cells_is_taken_back) {
    Bricks bricks(beside_trench);
    bricks.draw({{4, 4, 2}, {5, 4, 3}});
    const TetMesh before = bricks.mesh;
    const std::vector<std::uint32_t> neighbors = bricks.neighbors;
    const SurfaceRecoveryStats stats = bricks.recover(0.9);
    EXPECT_EQ(stats.found, 1u);
    EXPECT_EQ(stats.recovered, 0u);
    EXPECT_EQ(bricks.mesh.cells, before.cells);
    EXPECT_EQ(bricks.mesh.regions, before.regions);
    EXPECT_EQ(bricks.neighbors, neighbors);
    EXPECT_TRUE(std::equal(before.points.begin(), before.points.end(), bricks.mesh.points.begin()));
}

TEST(RecoverOnSurface, a_subsegment_on_the_surface_stays_as_it_is) {
    Bricks bricks(in_block);
    bricks.draw({{1, 4, 3}, {1, 4, 4}});
    const TetMesh before = bricks.mesh;
    EXPECT_EQ(bricks.recover().found, 0u);
    EXPECT_EQ(bricks.mesh.cells, before.cells);
    EXPECT_EQ(bricks.mesh.regions, before.regions);
}

// Of random cells.
Bricks random_ball(std::uint32_t seed) {
    return Bricks(
        fixtures::random_case("ball", fixtures::AnalyticField({fixtures::ball({}, 7)}, 9), 1, seed));
}

// Calls `body` with a copy of the bricks and every n-th of their edges beside the surface; returns how many
// there were.
template <typename Body>
std::size_t for_edges(const Bricks& bricks, std::size_t every, Body body) {
    const auto edges = bricks.edges_beside_surface();
    EXPECT_GT(edges.size(), 300u);
    std::size_t count = 0;
    for (std::size_t n = every / 2; n < edges.size(); n += every, ++count) {
        SCOPED_TRACE(n);
        body(Bricks(bricks), edges[n]);
    }
    return count;
}

// The membranes bend along a surface of random facets: at a vertex of it they part the cells on their side.
TEST(RecoverOnSurface, an_edge_from_surface_to_surface_is_recovered_whatever_cells_there_are) {
    for (std::uint32_t seed = 1; seed <= 2; ++seed) {
        for_edges(random_ball(seed), 10, [](Bricks bricks, VertexPair edge) {
            bricks.draw({bricks.grid[edge[0]], bricks.grid[edge[1]]});
            expect_recovered(bricks);
        });
    }
}

// In the facet between a subsegment and two edges of the surface there is a vertex, and one nearer to the
// subsegment: the membrane has both within it, unless another one is smaller.
TEST(RecoverOnSurface, a_membrane_has_vertices_within_it) {
    std::size_t within = 0, tried = 0;
    for_edges(random_ball(1), 3, [&](Bricks bricks, VertexPair edge) {
        const std::uint32_t a = edge[0], b = edge[1];
        const std::vector<std::uint32_t> at_a = bricks.joined_on_surface(a),
                                         at_b = bricks.joined_on_surface(b);
        std::vector<std::uint32_t> both;
        std::set_intersection(at_a.begin(), at_a.end(), at_b.begin(), at_b.end(), std::back_inserter(both));
        std::erase_if(both, [&](std::uint32_t c) { return !bricks.has_facet({a, b, c}); });
        if (both.size() != 1) return;
        const std::uint32_t middle = bricks.split_facet({a, b, both.front()});
        const std::uint32_t nearer = bricks.split_facet({a, b, middle});
        const bool side = bricks.lies(true, middle);
        bricks.draw({bricks.grid[a], bricks.grid[b]});
        expect_recovered(bricks);
        within += bricks.lies(!side, middle) && bricks.lies(!side, nearer);
        ++tried;
    });
    EXPECT_GT(tried, 20u);
    EXPECT_GE(within, least_within * tried);
}

// Cells above the first bound may be the price where cells are parted.
TEST(RecoverOnSurface, a_subsegment_that_parts_cells_costs_as_many_above_the_bound_as_it_may) {
    constexpr std::array shares{0.0, 0.005, 1.0};
    std::array<std::size_t, 3> recovered{};
    const std::size_t tried = for_edges(random_ball(1), 10, [&](const Bricks& ball, VertexPair edge) {
        for (std::size_t k = 0; k < shares.size(); ++k) {
            Bricks bricks = ball;
            bricks.max_radius_edge = 2;
            bricks.most_more_share = shares[k];
            bricks.draw({bricks.grid[edge[0]], bricks.grid[edge[1]]});
            recovered[k] += bricks.recover().recovered;
        }
    });
    EXPECT_LT(recovered[0], recovered[1]);
    EXPECT_LT(recovered[1], recovered[2]);
    EXPECT_EQ(recovered[2], tried);
}

// Whatever way its membrane goes, it leaves one end of the subsegment along the next subsegment.
TEST(RecoverOnSurface, a_membrane_has_the_next_subsegment_of_the_contour_on_its_rim) {
    std::size_t recovered = 0;
    const std::size_t tried = for_edges(random_ball(1), 10, [&](Bricks bricks, VertexPair edge) {
        const auto [a, b] = edge;
        bricks.draw({bricks.grid[a], bricks.grid[b]});
        for (const std::uint32_t w : bricks.joined_on_surface(a)) {
            bricks.draw({bricks.grid[a], bricks.grid[w]});
        }
        recovered += recovers_all(bricks);
    });
    EXPECT_GE(recovered, least_recovered * tried);
}

// Two structures that touch or overlap: the membrane takes nothing from the other.
TEST(RecoverOnSurface, a_subsegment_beside_another_structure_is_recovered) {
    std::size_t recovered = 0, tried = 0;
    for (const bool overlap : {false, true}) {
        const double x = overlap ? 2 : 3.5;
        const fixtures::AnalyticField field({fixtures::ball({-x, 0, 0}, 6), fixtures::ball({x, 0, 0}, 6)}, 9,
                                            !overlap);
        tried += for_edges(Bricks(fixtures::random_case("balls", field, 2, 1)), 10,
                           [&](Bricks bricks, VertexPair edge) {
                               bricks.draw({bricks.grid[edge[0]], bricks.grid[edge[1]]});
                               recovered += recovers_all(bricks, 2);
                           });
    }
    EXPECT_GE(recovered, least_recovered * tried);
}

}  // namespace
}  // namespace anatomesh::recover_on_surface_test
