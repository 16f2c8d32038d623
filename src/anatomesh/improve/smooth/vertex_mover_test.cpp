#include "anatomesh/improve/smooth/vertex_mover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <vector>

#include "anatomesh/improve/labelled_meshes_for_test.h"

namespace anatomesh::vertex_mover_test {
namespace {

using namespace fixtures;

// The vertices with a number that `every` divides, and for each of them when it was moved.
struct Moves {
    std::vector<std::uint32_t> vertices;
    std::vector<std::uint32_t> when;   // by vertex of the mesh; 0 for those not moved
    std::vector<std::uint32_t> times;  // by vertex of the mesh
};

template <class ForEach>
Moves moves_of(std::size_t count, std::size_t every, const ForEach& for_each) {
    Moves moves;
    for (std::uint32_t v = 0; v < count; ++v) {
        if (v % every == 0) moves.vertices.push_back(v);
    }
    moves.when.assign(count, 0);
    moves.times.assign(count, 0);
    std::atomic<std::uint32_t> clock = 0;
    for_each(moves.vertices, [&](std::uint32_t v) {
        moves.when[v] = ++clock;
        ++moves.times[v];
    });
    return moves;
}

void expect_each_once(const Moves& moves, std::size_t every) {
    for (std::size_t v = 0; v < moves.times.size(); ++v) ASSERT_EQ(moves.times[v], v % every == 0 ? 1u : 0u);
}

TEST(VertexMover, moves_vertices_that_share_a_cell_in_the_order_given) {
    for (LabelledCase& made : labelled_cases()) {
        SCOPED_TRACE(made.name);
        const VertexStars stars(made.mesh.cells, made.mesh.points.size());
        const VertexMover mover(made.mesh, stars, 2);
        for (const int threads : {1, 2, 8}) {
            for (const std::size_t every : {1u, 7u, 40u}) {
                const Moves moves = moves_of(
                    made.mesh.points.size(), every,
                    [&](const auto& all, const auto& move) { mover.for_each_in_order(all, threads, move); });
                expect_each_once(moves, every);
                for (const Cell& cell : made.mesh.cells) {
                    Cell listed = cell;
                    std::sort(listed.begin(), listed.end());
                    std::uint32_t last = 0;
                    for (const std::uint32_t v : listed) {
                        if (moves.when[v] == 0) continue;
                        ASSERT_GT(moves.when[v], last);
                        last = moves.when[v];
                    }
                }
            }
        }
    }
}

// What is the same at any thread count is which one of two vertices that share a cell moves first.
TEST(VertexMover, moves_vertices_apart_in_one_order_at_any_thread_count) {
    for (LabelledCase& made : labelled_cases()) {
        SCOPED_TRACE(made.name);
        const VertexStars stars(made.mesh.cells, made.mesh.points.size());
        const VertexMover mover(made.mesh, stars, 2);
        for (const std::size_t every : {1u, 3u}) {
            const auto moves_on = [&](int threads) {
                return moves_of(made.mesh.points.size(), every, [&](const auto& all, const auto& move) {
                    mover.for_each_apart(all, threads, move);
                });
            };
            const Moves one = moves_on(1), many = moves_on(8);
            expect_each_once(one, every);
            expect_each_once(many, every);
            for (const Cell& cell : made.mesh.cells) {
                for (const auto& [i, j] : cell_edges) {
                    ASSERT_EQ(one.when[cell[i]] < one.when[cell[j]], many.when[cell[i]] < many.when[cell[j]]);
                }
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::vertex_mover_test
