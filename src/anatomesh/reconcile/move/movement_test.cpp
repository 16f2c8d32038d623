#include "anatomesh/reconcile/move/movement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace anatomesh::movement_test {
namespace {

struct Problem {
    std::vector<MovementNode> nodes;
    std::vector<MovementEdge> edges;
    std::vector<double> usual;
};

// The energy by its definition: half of what is minimised, with the mass of an edge at its ends.
double energy(const Problem& problem, const std::vector<Vec2>& moves, double smoothing) {
    double sum = 0;
    for (const MovementEdge& edge : problem.edges) {
        const Vec2 a = moves[edge.a], b = moves[edge.b];
        sum += 0.25 * edge.length * (squared_length(a) + squared_length(b)) +
               0.5 * smoothing * smoothing / edge.length * squared_length(a - b);
    }
    return sum;
}

// Closed rings of nodes, some of which share a stretch, with anchors of groups and pinned nodes here and
// there.
Problem random_problem(unsigned seed, int rings, int groups, double held) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(0, 1);
    Problem problem;
    for (int g = 0; g < groups; ++g) problem.usual.push_back(share(random));
    for (int ring = 0; ring < rings; ++ring) {
        const auto first = static_cast<std::uint32_t>(problem.nodes.size());
        const std::uint32_t count = 3 + static_cast<std::uint32_t>(40 * share(random));
        for (std::uint32_t n = 0; n < count; ++n) {
            MovementNode node;
            const double angle = 6.28 * share(random), kind = share(random);
            const Vec2 direction{std::cos(angle), std::sin(angle)};
            if (kind < held && groups > 0) {
                const auto group = static_cast<std::uint32_t>(share(random) * groups);
                node = {Hold::anchor, group, share(random), share(random) * direction};
            } else if (kind < 1.3 * held) {
                node = {Hold::pinned, 0, 0, share(random) * direction};
            }
            problem.nodes.push_back(node);
            problem.edges.push_back({first + n, first + (n + 1) % count, 0.05 + 3 * share(random)});
        }
        // A stretch from one node to another beside the ring: three edges meet at its ends.
        if (ring % 3 == 0 && count > 8) {
            const auto middle = static_cast<std::uint32_t>(problem.nodes.size());
            problem.nodes.emplace_back();
            problem.edges.push_back({first, middle, 1.5});
            problem.edges.push_back({middle, first + count / 2, 0.7});
        }
    }
    return problem;
}

std::vector<Vec2> solved(const Problem& problem, double smoothing) {
    return solve_movement(problem.nodes, problem.edges, problem.usual, smoothing);
}

TEST(Movement, no_other_movement_of_a_node_has_less_energy) {
    for (const unsigned seed : {1u, 2u, 3u, 4u}) {
        for (const double held : {0.05, 0.3}) {
            const Problem problem = random_problem(seed, 12, 9, held);
            const std::vector<Vec2> moves = solved(problem, 5);
            const double least = energy(problem, moves, 5);
            ASSERT_GT(least, 0);
            for (std::size_t n = 0; n < moves.size(); ++n) {
                if (problem.nodes[n].hold != Hold::free) continue;
                for (const Vec2 step : {Vec2{0.01, 0}, {-0.01, 0}, {0, 0.01}, {0, -0.01}}) {
                    std::vector<Vec2> other = moves;
                    other[n] = other[n] + step;
                    EXPECT_GE(energy(problem, other, 5), least) << seed << ", node " << n;
                }
            }
        }
    }
}

TEST(Movement, anchors_of_a_group_go_to_one_position_which_is_the_best) {
    for (const unsigned seed : {5u, 6u, 7u}) {
        const Problem problem = random_problem(seed, 12, 9, 0.2);
        const std::vector<Vec2> moves = solved(problem, 5);
        const double least = energy(problem, moves, 5);
        for (std::uint32_t g = 0; g < problem.usual.size(); ++g) {
            std::vector<double> positions;
            for (std::size_t n = 0; n < moves.size(); ++n) {
                const MovementNode& node = problem.nodes[n];
                if (node.hold != Hold::anchor || node.group != g || squared_length(node.direction) < 0.01)
                    continue;
                EXPECT_NEAR(cross(moves[n], node.direction), 0, 1e-12);
                positions.push_back(node.place +
                                    dot(moves[n], node.direction) / squared_length(node.direction));
            }
            for (const double position : positions) EXPECT_NEAR(position, positions.front(), 1e-9);
            for (const double step : {-0.01, 0.01}) {
                std::vector<Vec2> other = moves;
                for (std::size_t n = 0; n < moves.size(); ++n) {
                    const MovementNode& node = problem.nodes[n];
                    if (node.hold == Hold::anchor && node.group == g)
                        other[n] = other[n] + step * node.direction;
                }
                // The pull to the usual position is small beside it.
                EXPECT_GE(energy(problem, other, 5), least - 1e-5) << seed << ", group " << g;
            }
        }
    }
}

TEST(Movement, pinned_nodes_move_as_asked_and_rings_without_any_stay) {
    Problem problem = random_problem(8, 6, 0, 0.2);
    const std::size_t before = problem.nodes.size();
    for (std::uint32_t n = 0; n < 10; ++n) {
        const auto first = static_cast<std::uint32_t>(before);
        problem.nodes.emplace_back();
        problem.edges.push_back({first + n, first + (n + 1) % 10, 1});
    }
    const std::vector<Vec2> moves = solved(problem, 5);
    ASSERT_EQ(moves.size(), problem.nodes.size());
    for (std::size_t n = 0; n < moves.size(); ++n) {
        if (problem.nodes[n].hold == Hold::pinned) {
            EXPECT_EQ(moves[n], problem.nodes[n].direction);
        }
        if (n >= before) {
            EXPECT_EQ(moves[n], Vec2{});
        }
    }
}

// By the closed form: a straight chain between two pinned ends, d'' = d / smoothing^2.
TEST(Movement, between_two_ends_it_is_the_sum_of_two_exponentials) {
    const double smoothing = 5, length = 20;
    const int count = 2000;
    Problem problem;
    for (int n = 0; n <= count; ++n) problem.nodes.emplace_back();
    problem.nodes.front() = {Hold::pinned, 0, 0, {1, 0}};
    problem.nodes.back() = {Hold::pinned, 0, 0, {0, 2}};
    for (std::uint32_t n = 0; n < count; ++n) problem.edges.push_back({n, n + 1, length / count});
    const std::vector<Vec2> moves = solved(problem, smoothing);
    for (int n = 0; n <= count; ++n) {
        const double s = length * n / count;
        const double from_start = std::sinh((length - s) / smoothing) / std::sinh(length / smoothing);
        const double from_end = std::sinh(s / smoothing) / std::sinh(length / smoothing);
        EXPECT_NEAR(moves[static_cast<std::size_t>(n)].x, from_start, 1e-5);
        EXPECT_NEAR(moves[static_cast<std::size_t>(n)].y, 2 * from_end, 1e-5);
    }
}

}  // namespace
}  // namespace anatomesh::movement_test
