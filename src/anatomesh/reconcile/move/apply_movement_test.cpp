#include "anatomesh/reconcile/move/apply_movement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::apply_movement_test {
namespace {

using namespace crossing_fixtures;

bool is_sound(const ContourSet& set) {
    for (const Slice& slice : set.slices) {
        if (!slice_faults(plane_rings(set, slice), set.exclusive).empty()) return false;
    }
    return true;
}

std::vector<Vec2> random_moves(std::size_t count, double size, std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Vec2> moves(count);
    for (Vec2& move : moves) move = {size * unit(random), size * unit(random)};
    return moves;
}

// Laws, for moves of any size: contours stay sound, no point passes the bound, planes keep their points.
TEST(ApplyMovement, contours_stay_sound_and_within_the_bound) {
    std::mt19937 random(1);
    for (const double size : {0.1, 1.0, 10.0, 100.0}) {
        for (const double bound : {0.5, 5.0}) {
            ContourSet set = drawn_ball(20, three_stacks(15, 7, 0.05), {0, 0.3}, random);
            const OriginalPositions drawn = original_positions(set);
            const ContourGraph graph = make_contour_graph(set);
            apply_movement(set, graph, drawn, random_moves(graph.point_of_node.size(), size, random), bound,
                           2);
            EXPECT_TRUE(is_sound(set)) << size;
            double farthest = 0;
            for (const Contour& contour : set.contours) {
                for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count;
                     ++k) {
                    farthest = std::max(farthest, length(set.points[k] - drawn.at[k]));
                    EXPECT_NEAR(set.slices[contour.slice].plane.signed_distance(set.points[k]), 0, 1e-9);
                }
            }
            EXPECT_LE(farthest, bound);
            EXPECT_GT(farthest, 0);
        }
    }
}

TEST(ApplyMovement, small_moves_are_made_in_full_and_no_move_keeps_the_bits) {
    std::mt19937 random(2);
    ContourSet set = drawn_ball(20, three_stacks(15, 7, 0.05), {}, random);
    const ContourSet before = set;
    const OriginalPositions drawn = original_positions(set);
    const ContourGraph graph = make_contour_graph(set);
    apply_movement(set, graph, drawn, std::vector<Vec2>(graph.point_of_node.size()), 1, 1);
    EXPECT_EQ(set.points, before.points);
    const Vec2 move{0.02, -0.01};
    apply_movement(set, graph, drawn, std::vector<Vec2>(graph.point_of_node.size(), move), 1, 1);
    for (const Contour& contour : set.contours) {
        const Plane& plane = set.slices[contour.slice].plane;
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            const Vec2 way = plane.to_plane(set.points[k]) - plane.to_plane(before.points[k]);
            EXPECT_NEAR(way.x, move.x, 1e-9);
            EXPECT_NEAR(way.y, move.y, 1e-9);
        }
    }
}

TEST(ApplyMovement, the_number_of_threads_does_not_matter) {
    std::vector<std::vector<Vec3>> points;
    for (const int threads : {1, 3}) {
        std::mt19937 random(3);
        ContourSet set = drawn_ball(20, three_stacks(15, 7, 0.05), {0, 0.3}, random);
        const ContourGraph graph = make_contour_graph(set);
        const std::vector<Vec2> moves = random_moves(graph.point_of_node.size(), 3, random);
        apply_movement(set, graph, original_positions(set), moves, 5, threads);
        points.push_back(set.points);
    }
    EXPECT_EQ(points[0], points[1]);
}

}  // namespace
}  // namespace anatomesh::apply_movement_test
