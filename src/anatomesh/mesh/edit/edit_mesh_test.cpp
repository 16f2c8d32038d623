#include "anatomesh/mesh/edit/edit_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::edit_mesh_test {
namespace {

TetMesh shaken_bricks(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shift(-0.2, 0.2);
    return testing::brick_mesh(
        {6, 5, 7}, [](int i, int, int) { return static_cast<Region>(1 + i / 3); },
        [&](int i, int j, int k) {
            return Vec3{i + shift(random), j + shift(random), k + shift(random)};
        });
}

bool all_positive(const EditMesh& mesh, std::span<const Cell> cells) {
    return std::all_of(cells.begin(), cells.end(), [&](const Cell& c) {
        return orient3d(mesh.point(c[0]), mesh.point(c[1]), mesh.point(c[2]), mesh.point(c[3])) > 0;
    });
}

// Three cells for two at every facet, two for three at every edge, where these are positive.
std::vector<CellExchange> possible_exchanges(const EditMesh& mesh) {
    std::vector<CellExchange> all;
    const auto add = [&](CellExchange exchange) {
        exchange.regions.assign(exchange.added.size(), mesh.region(exchange.removed[0]));
        const bool one_region =
            std::all_of(exchange.removed.begin(), exchange.removed.end(),
                        [&](std::uint32_t c) { return mesh.region(c) == exchange.regions[0]; });
        if (one_region && all_positive(mesh, exchange.added)) all.push_back(std::move(exchange));
    };
    for (std::uint32_t c = 0; c < mesh.cell_count(); ++c) {
        if (!mesh.alive(c)) continue;
        const Cell& cell = mesh.cell(c);
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t beyond = mesh.neighbor(c, i);
            if (beyond == no_cell || beyond < c) continue;
            std::uint32_t above = no_cell;
            for (int n = 0; n < 4; ++n) {
                if (mesh.neighbor(beyond, n) == c) above = mesh.cell(beyond)[n];
            }
            const auto& f = facet_vertices[i];
            CellExchange exchange{{c, beyond}, {}, {}, {}};
            for (std::size_t n = 0; n < 3; ++n)
                exchange.added.push_back({cell[i], above, cell[f[n]], cell[f[(n + 1) % 3]]});
            add(std::move(exchange));
        }
        for (int e = 0; e < 6; ++e) {
            EdgeRing ring;
            mesh.ring(c, e, ring);
            if (!ring.closed || ring.cells.size() != 3) continue;
            const auto& r = ring.ring;
            add({ring.cells, {{r[0], r[1], r[2], ring.b}, {r[0], r[2], r[1], ring.a}}, {}, {}});
        }
    }
    return all;
}

std::multiset<Cell> sorted_cells(const TetMesh& mesh) {
    std::multiset<Cell> cells;
    for (Cell cell : mesh.cells) {
        std::sort(cell.begin(), cell.end());
        cells.insert(cell);
    }
    return cells;
}

EditMesh editable(const TetMesh& mesh) {
    return {mesh, cell_neighbors(mesh.cells, mesh.points.size())};
}

TEST(EditMesh, exchanges_at_the_same_time_are_those_one_by_one_for_any_threads) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE(seed);
        const TetMesh bricks = shaken_bricks(seed);
        EditMesh one = editable(bricks), several = editable(bricks);
        std::size_t done_in_all = 0;
        for (int round = 0; round < 6; ++round) {
            std::vector<CellExchange> exchanges = possible_exchanges(one);
            std::shuffle(exchanges.begin(), exchanges.end(), std::mt19937(seed));
            std::vector<CellExchange> same = exchanges;
            EditMesh one_by_one = one;
            const std::vector<std::uint8_t> done = one.replace_apart(exchanges, 1);
            EXPECT_EQ(several.replace_apart(same, 3), done);
            std::set<std::uint32_t> taken;
            for (std::size_t n = 0; n < exchanges.size(); ++n) {
                std::set<std::uint32_t> vertices;
                for (const Cell& cell : exchanges[n].added) vertices.insert(cell.begin(), cell.end());
                const bool apart = std::none_of(vertices.begin(), vertices.end(),
                                                [&](std::uint32_t v) { return taken.count(v) != 0; });
                ASSERT_EQ(done[n] != 0, apart);
                if (!apart) continue;
                ++done_in_all;
                taken.insert(vertices.begin(), vertices.end());
                ASSERT_EQ(exchanges[n].slots, same[n].slots);
                ASSERT_EQ(exchanges[n].slots.size(), exchanges[n].added.size());
                for (std::size_t k = 0; k < exchanges[n].slots.size(); ++k)
                    ASSERT_EQ(one.cell(exchanges[n].slots[k]), exchanges[n].added[k]);
            }
            // Numbers may differ from those of exchanges one by one: cells are told by their vertices.
            std::vector<std::uint32_t> slots, neighbors;
            for (std::size_t n = 0; n < exchanges.size(); ++n) {
                if (done[n])
                    one_by_one.replace(exchanges[n].removed, exchanges[n].added, exchanges[n].regions, slots);
            }
            EditMesh copy = one;
            const TetMesh now = std::move(copy).take(neighbors);
            EXPECT_EQ(neighbors, cell_neighbors(now.cells, now.points.size()));
            EXPECT_EQ(sorted_cells(now), sorted_cells(std::move(one_by_one).take(neighbors)));
        }
        EXPECT_GT(done_in_all, 30u);
        std::vector<std::uint32_t> of_one, of_several;
        const TetMesh a = std::move(one).take(of_one), b = std::move(several).take(of_several);
        EXPECT_EQ(a.cells, b.cells);
        EXPECT_EQ(a.regions, b.regions);
        EXPECT_EQ(of_one, of_several);
    }
}

// Every vertex still knows a cell of its own.
TEST(EditMesh, stars_are_whole_after_exchanges_at_the_same_time) {
    EditMesh mesh = editable(shaken_bricks(3));
    for (int round = 0; round < 4; ++round) {
        std::vector<CellExchange> exchanges = possible_exchanges(mesh);
        mesh.replace_apart(exchanges, 2);
        std::vector<std::vector<std::uint32_t>> cells_at(mesh.point_count());
        for (std::uint32_t c = 0; c < mesh.cell_count(); ++c) {
            if (!mesh.alive(c)) continue;
            for (const std::uint32_t v : mesh.cell(c)) cells_at[v].push_back(c);
        }
        for (std::uint32_t v = 0; v < mesh.point_count(); ++v) {
            std::vector<std::uint32_t> star;
            mesh.shared_star(v, star);
            std::sort(star.begin(), star.end());
            ASSERT_EQ(star, cells_at[v]);
        }
    }
}

// Cells with their numbers.
TEST(EditMesh, an_attempt_that_is_not_kept_leaves_everything_as_it_was) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        EditMesh mesh = editable(shaken_bricks(seed));
        std::mt19937 random(seed);
        std::vector<std::uint32_t> slots;
        const auto change = [&] {
            const std::vector<CellExchange> exchanges = possible_exchanges(mesh);
            const CellExchange& exchange = exchanges[random() % exchanges.size()];
            mesh.replace(exchange.removed, exchange.added, exchange.regions, slots);
            mesh.set_region(slots[0], static_cast<Region>(random() % 3));
            const auto v = static_cast<std::uint32_t>(random() % mesh.point_count());
            mesh.move_point(v, mesh.point(v) + Vec3{1e-3, 0, 0});
        };
        for (int n = 0; n < 5; ++n) change();
        const EditMesh before = mesh;
        mesh.begin_attempt();
        for (int n = 0; n < 20; ++n) change();
        mesh.end_attempt(false);
        ASSERT_GE(mesh.cell_count(), before.cell_count());
        for (std::uint32_t c = 0; c < mesh.cell_count(); ++c) {
            if (c >= before.cell_count() || !before.alive(c)) {
                ASSERT_FALSE(mesh.alive(c));
                continue;
            }
            ASSERT_EQ(mesh.cell(c), before.cell(c));
            ASSERT_EQ(mesh.region(c), before.region(c));
            for (int i = 0; i < 4; ++i) ASSERT_EQ(mesh.neighbor(c, i), before.neighbor(c, i));
        }
        for (std::uint32_t v = 0; v < before.point_count(); ++v) ASSERT_EQ(mesh.point(v), before.point(v));
        // And it goes on as a mesh does.
        for (int n = 0; n < 5; ++n) change();
        std::vector<std::uint32_t> neighbors;
        const TetMesh now = std::move(mesh).take(neighbors);
        EXPECT_EQ(neighbors, cell_neighbors(now.cells, now.points.size()));
    }
}

// Whether a cell has other vertices, places of these, regions or neighbours in the two meshes, or is in one
// alone.
bool differs(const EditMesh& one, const EditMesh& other, std::uint32_t c) {
    const bool in_one = c < one.cell_count() && one.alive(c),
               in_other = c < other.cell_count() && other.alive(c);
    if (!in_one && !in_other) return false;
    if (in_one != in_other || one.cell(c) != other.cell(c) || one.region(c) != other.region(c)) return true;
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t v = one.cell(c)[i];
        if (one.neighbor(c, i) != other.neighbor(c, i) || one.point(v) != other.point(v)) return true;
    }
    return false;
}

TEST(EditMesh, cells_that_differ_since_an_attempt_began_are_among_the_changed_ones) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        EditMesh mesh = editable(shaken_bricks(seed));
        std::mt19937 random(seed);
        std::vector<std::uint32_t> slots;
        for (const bool keep : {true, false, true}) {
            const EditMesh before = mesh;
            mesh.begin_attempt();
            EXPECT_TRUE(mesh.changed_cells().empty());
            for (int n = 0; n < 8; ++n) {
                const std::vector<CellExchange> exchanges = possible_exchanges(mesh);
                const CellExchange& exchange = exchanges[random() % exchanges.size()];
                if (n % 2 == 0) mesh.replace(exchange.removed, exchange.added, exchange.regions, slots);
                if (n % 3 == 0) mesh.set_region(exchange.removed[0], static_cast<Region>(random() % 3));
                const auto v = static_cast<std::uint32_t>(random() % mesh.point_count());
                if (n % 4 == 0) mesh.move_point(v, mesh.point(v) + Vec3{1e-3, 0, 0});
            }
            const std::vector<std::uint32_t> changed = mesh.changed_cells();
            const std::vector<EditMesh::CellState> states = mesh.states_before(changed);
            for (std::size_t n = 0; n < changed.size(); ++n) {
                const bool was = changed[n] < before.cell_count() && before.alive(changed[n]);
                ASSERT_EQ(states[n].cell[0] != no_cell, was);
                if (!was) continue;
                ASSERT_EQ(states[n].cell, before.cell(changed[n]));
                ASSERT_EQ(states[n].region, before.region(changed[n]));
            }
            ASSERT_TRUE(std::is_sorted(changed.begin(), changed.end()));
            ASSERT_TRUE(std::adjacent_find(changed.begin(), changed.end()) == changed.end());
            std::size_t different = 0;
            for (std::uint32_t c = 0; c < mesh.cell_count(); ++c) {
                if (!differs(before, mesh, c)) continue;
                ++different;
                ASSERT_TRUE(std::binary_search(changed.begin(), changed.end(), c));
            }
            EXPECT_GT(different, 8u);
            EXPECT_LE(changed.size(),
                      5 * (different + 3));  // beside each at most four; three may be as they were
            mesh.end_attempt(keep);
        }
    }
}

}  // namespace
}  // namespace anatomesh::edit_mesh_test
