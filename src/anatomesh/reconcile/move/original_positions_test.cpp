#include "anatomesh/reconcile/move/original_positions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/reconcile/move/split_at_endpoints.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh::original_positions_test {
namespace {

using namespace crossing_fixtures;

ContourSet polygon(const std::vector<Vec3>& points) {
    ContourSet set;
    set.structures.push_back({1, "solid", {200, 200, 200}});
    set.slices.push_back({make_plane({}, {0, 0, 1}), 0, 1, "0"});
    set.contours.push_back({0, 0, 0, static_cast<std::uint32_t>(points.size())});
    set.points = points;
    return set;
}

TEST(OriginalPositions, points_that_stay_keep_theirs_to_the_bit_and_others_lie_between) {
    const ContourSet before = polygon({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}});
    OriginalPositions drawn = original_positions(before);
    drawn.at[0] = {0.1, -1, 0};
    drawn.at[1] = {4, -0.3, 0};
    drawn.is_drawn[3] = false;
    // One put in, one moved, one taken out.
    const ContourSet after = polygon({{0, 0, 0}, {1, 0, 0}, {4, 0, 0}, {3.9, 4, 0}});
    const OriginalPositions carried = carry_over(before, drawn, after, 0.05);
    EXPECT_EQ(carried.at[0], drawn.at[0]);
    EXPECT_EQ(carried.at[2], drawn.at[1]);
    EXPECT_EQ(carried.is_drawn, (std::vector<bool>{true, false, true, false}));
    EXPECT_LT(length(carried.at[1] - Vec3{1.075, -0.825, 0}), 1e-12);  // a quarter of the way
    // From (4, 0) over (3.9, 4) to (0, 0): displaced by something between the two.
    EXPECT_GT(carried.at[3].y, 3);
    EXPECT_LT(carried.at[3].y, 3.7);
}

TEST(OriginalPositions, of_a_contour_without_a_known_point_lie_where_it_is) {
    const ContourSet before = polygon({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}}),
                     after = polygon({{1, 0, 0}, {5, 0, 0}, {5, 4, 0}});
    const OriginalPositions carried = carry_over(before, original_positions(before), after, 0.05);
    EXPECT_EQ(carried.at, after.points);
    EXPECT_EQ(carried.is_drawn, (std::vector<bool>{false, false, false}));
}

// A vertex that became a common point is still the one that was drawn; what came beside it is not.
TEST(OriginalPositions, a_point_that_came_in_the_place_of_one_keeps_its) {
    const std::vector<Vec3> square{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
    for (std::size_t moved = 0; moved < 4; ++moved) {
        for (const bool is_near : {true, false}) {
            const ContourSet before = polygon(square);
            OriginalPositions drawn = original_positions(before);
            for (std::size_t k = 0; k < 4; ++k) drawn.at[k] += Vec3{0.1 * static_cast<double>(k), 7, 0};
            std::vector<Vec3> points = square;
            points[moved] += Vec3{is_near ? 0.03 : 0.3, 0, 0};
            const Vec3 beside = 0.5 * (points[moved] + points[(moved + 1) % 4]);
            points.insert(points.begin() + static_cast<std::ptrdiff_t>(moved) + 1, beside);
            const OriginalPositions carried = carry_over(before, drawn, polygon(points), 0.05);
            for (std::size_t k = 0; k < 4; ++k) {
                const std::size_t at = k <= moved ? k : k + 1;
                EXPECT_EQ(carried.is_drawn[at], k != moved || is_near);
                if (carried.is_drawn[at]) {
                    EXPECT_EQ(carried.at[at], drawn.at[k]);
                }
            }
            EXPECT_FALSE(carried.is_drawn[moved + 1]);
        }
    }
}

TEST(OriginalPositions, one_known_point_is_enough) {
    const ContourSet before = polygon({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}}),
                     after = polygon({{0, 0, 0}, {5, 0, 0}, {4.02, 4, 0}});
    OriginalPositions drawn = original_positions(before);
    drawn.at[0] = {0, 1, 0};
    const OriginalPositions carried = carry_over(before, drawn, after, 0.05);
    EXPECT_EQ(carried.is_drawn, (std::vector<bool>{true, false, true}));
    EXPECT_EQ(carried.at[2], before.points[2]);
}

// Every end becomes a vertex, unless one is near; what was there stays.
TEST(SplitAtEnds, gives_contours_a_vertex_where_slices_differ) {
    std::mt19937 random(5);
    for (int n = 0; n < 6; ++n) {
        ContourSet set = drawn_ball(30, three_stacks(24, 6, 0.05), {1.0, 0.7, 40}, random);
        const ContourSet before = set;
        RunContext context;
        const auto compare = [&] {
            const auto patches = plane_patches(set);
            return compare_planes(set, patches, crossing_pairs(patches, 3), 3, context);
        };
        const double least = 0.1;  // mm: no vertex comes nearer to another one
        const std::size_t added = split_at_endpoints(set, compare());
        EXPECT_GT(added, 500u);
        EXPECT_EQ(set.points.size(), before.points.size() + added);
        std::size_t inside = 0;
        for (const LineComparison& comparison : compare()) {
            for (const auto* ends : {&comparison.endpoints_a, &comparison.endpoints_b}) {
                for (const IntervalEndpoint& end : *ends) {
                    const double nearest =
                        std::min(length(end.at - set.points[end.from]), length(end.at - set.points[end.to]));
                    inside += nearest > least && comparison.difference_mm > 0;
                }
            }
        }
        EXPECT_EQ(inside, 0u);
        for (std::size_t c = 0; c < set.contours.size(); ++c) {
            const auto old = before.points_of(before.contours[c]), fresh = set.points_of(set.contours[c]);
            std::size_t kept = 0;
            for (const Vec3& p : fresh) kept += kept < old.size() && p == old[kept];
            EXPECT_EQ(kept, old.size()) << "contour " << c;
        }
    }
}

TEST(SplitAtEnds, leaves_slices_that_agree_alone) {
    std::mt19937 random(6);
    ContourSet set = cut(polytope(30, 20, random), three_stacks(28, 7, 0.1));
    std::vector<LineComparison> comparisons;
    {
        RunContext context;
        const auto patches = plane_patches(set);
        comparisons = compare_planes(set, patches, crossing_pairs(patches, 3), 3, context);
    }
    for (LineComparison& comparison : comparisons) comparison.difference_mm = 0;
    EXPECT_EQ(split_at_endpoints(set, comparisons), 0u);
}

}  // namespace
}  // namespace anatomesh::original_positions_test
