#include "anatomesh/contour/walls/close_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "anatomesh/contour/walls_for_test.h"

namespace anatomesh::close_gaps_test {
namespace {

using namespace fixtures;
TEST(CloseGaps, sides_that_run_within_the_width_become_one_and_no_vertex_moves) {
    for (const double gap : {0.4, 0.1, 0.0, -0.1, -0.4}) {
        for (const auto& [below, above] :
             {std::pair{40, 40}, {40, 37}, {37, 40}, {40, 20}, {20, 41}, {80, 20}}) {
            const ContourSet before = slice_of(slabs(gap, below, above));
            ContourSet after = before;
            const ConflationStats stats = close_gaps(after, {0.7});
            SCOPED_TRACE(testing::Message()
                         << "gap " << gap << ", " << below << " and " << above << " steps");
            EXPECT_TRUE(keeps_every_vertex(before, after));
            EXPECT_LT(stats.widest_mm, 0.7);
            // All but the two ends, where one may reach beyond the other.
            EXPECT_GT(shared_length(after, 0), 18.5);
        }
    }
}

TEST(CloseGaps, gaps_wider_than_the_width_stay) {
    for (const double gap : {0.5, -0.5, 2.0}) {
        const ContourSet before = slice_of({{0, box(0, 0, 10, 10)}, {1, box(10 + gap, 0, 20, 10)}});
        ContourSet after = before;
        const ConflationStats stats = close_gaps(after, {0.5});
        EXPECT_EQ(after.points, before.points);
        EXPECT_EQ(stats.contours_changed, 0u);
        EXPECT_EQ(stats.area_mm2, 0);
    }
}

TEST(CloseGaps, the_area_that_changes_hands_is_that_of_the_gap) {
    ContourSet set = slice_of({{0, box(0, 0, 10, 10)}, {1, box(10.25, 0, 20, 10)}});
    const ConflationStats stats = close_gaps(set, {0.3});
    EXPECT_NEAR(stats.area_mm2, 2.5, 1e-12);
    EXPECT_NEAR(stats.widest_mm, 0.25, 1e-12);
    EXPECT_EQ(stats.slices, 1u);
    EXPECT_NEAR(shared_length(set, 0), 10, 1e-12);
}

TEST(CloseGaps, walls_between_nested_contours_stay) {
    // An organ in another one, 0.2 from its side all round; a hole filled but for 0.2 is closed.
    Polygon hole = box(2, 2, 8, 8);
    std::reverse(hole.begin(), hole.end());
    const ContourSet nested = slice_of({{0, box(0, 0, 10, 10)}, {1, box(0.2, 0.2, 9.8, 9.8)}});
    ContourSet after = nested;
    EXPECT_EQ(close_gaps(after, {0.5}).contours_changed, 0u);
    EXPECT_EQ(after.points, nested.points);
    ContourSet filled = slice_of({{0, box(0, 0, 10, 10)}, {0, hole}, {1, box(2.2, 2.2, 7.8, 7.8)}});
    close_gaps(filled, {0.5});
    EXPECT_GE(shared_length(filled, 1), 4 * 5.6);  // all round
}

TEST(CloseGaps, a_lone_vertex_beside_a_contour_is_left_alone) {
    const ContourSet before = slice_of({{0, box(0, 0, 10, 10)}, {1, {{10.2, 5}, {15, 0}, {15, 10}}}});
    ContourSet after = before;
    EXPECT_EQ(close_gaps(after, {0.5}).contours_changed, 0u);
    EXPECT_EQ(after.points, before.points);
}

TEST(CloseGaps, three_structures_meet) {
    const ContourSet before =
        slice_of({{0, box(0, 0, 10, 10)}, {1, box(10.2, 0, 20, 4.9)}, {2, box(10.2, 5.1, 20, 10)}});
    ContourSet after = before;
    close_gaps(after, {0.5});
    EXPECT_TRUE(keeps_every_vertex(before, after));
    EXPECT_GT(shared_length(after, 0), 9.7);
    EXPECT_GT(shared_length(after, 1), 4.8 + 9.7);
    EXPECT_GT(shared_length(after, 2), 4.8 + 9.7);
}

TEST(CloseGaps, what_would_touch_itself_is_given_up) {
    // A strip thinner than the width, between two sides of another structure's notch.
    const Polygon notch{{0, 0}, {10, 0}, {10, 10}, {5.3, 10}, {5.3, 3}, {5.0, 3}, {5.0, 10}, {0, 10}};
    const Polygon strip{{5.1, 3.1}, {5.2, 3.1}, {5.2, 10}, {5.1, 10}};
    const ContourSet before = slice_of({{0, notch}, {1, strip}});
    ContourSet after = before;
    const ConflationStats stats = close_gaps(after, {0.35});
    EXPECT_TRUE(keeps_every_vertex(before, after));
    for (const Contour& contour : after.contours) {
        const auto points = after.points_of(contour);
        std::vector<Vec3> sorted(points.begin(), points.end());
        std::sort(sorted.begin(), sorted.end(), [](Vec3 p, Vec3 q) { return lexicographic_less(p, q); });
        EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end())
            << "structure " << contour.structure;
    }
    EXPECT_LT(stats.widest_mm, 0.35);
}

TEST(CloseGaps, what_lies_beyond_a_contour_is_no_neighbour) {
    // The inner side of a thin structure inside another one, and the far side of a thin one between two
    // others.
    const std::vector<std::vector<Drawing>> layouts{
        {{0, box(0, 0, 10, 10)}, {1, box(9.6, 2, 9.9, 8)}},
        {{0, box(9.6, 2, 9.9, 8)}, {1, box(0, 0, 10, 10)}},
        {{0, box(0, 0, 10, 10)}, {1, {{9.7, 2}, {9.9, 5}, {9.7, 8}}}},
        {{0, {{9.7, 2}, {9.9, 5}, {9.7, 8}}}, {1, {{0, 0}, {10, 0}, {10, 5}, {10, 10}, {0, 10}}}}};
    for (const auto& layout : layouts) {
        const ContourSet before = slice_of(layout);
        ContourSet after = before;
        close_gaps(after, {0.5});
        EXPECT_EQ(after.points, before.points);
    }
    const std::vector<Polygon> row{box(0, 0, 10, 10), box(10.05, 0.1, 10.3, 9.9), box(10.35, 0, 20, 10)};
    for (const auto& order :
         {std::array{0u, 1u, 2u}, {0u, 2u, 1u}, {1u, 0u, 2u}, {1u, 2u, 0u}, {2u, 0u, 1u}, {2u, 1u, 0u}}) {
        std::vector<Drawing> drawings(3);
        for (std::uint32_t n = 0; n < 3; ++n) drawings[order[n]] = {order[n], row[n]};
        ContourSet after = slice_of(drawings);
        close_gaps(after, {0.5});
        // All three together cover what they did, and the strips.
        double sum = 0;
        for (const Contour& contour : after.contours) sum += signed_area(after, contour);
        EXPECT_GE(sum, 100 + 0.25 * 9.8 + 96.5 - 1e-9);
        EXPECT_LE(sum, 200 + 0.01);
    }
}

TEST(CloseGaps, no_contour_is_turned_inside_out_or_changes_its_place_among_others) {
    // An island beside the wall that would jump over it.
    const ContourSet before =
        slice_of({{0, box(10.3, 0, 20, 10)}, {1, box(0, 0, 10, 10)}, {1, box(10.1, 4, 10.2, 5)}});
    ContourSet after = before;
    close_gaps(after, {0.5});
    const auto inside = [&](Vec3 p, const Contour& contour) {
        bool in = false;
        const auto q = after.points_of(contour);
        for (std::size_t n = 0; n < q.size(); ++n) {
            const Vec3 a = q[n], b = q[(n + 1) % q.size()];
            if ((a.y <= p.y) != (b.y <= p.y) && a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) > p.x) in = !in;
        }
        return in;
    };
    for (const Contour& contour : after.contours) {
        EXPECT_GT(signed_area(after, contour), 0);
        for (const Contour& other : after.contours) {
            if (other.structure != contour.structure || other.first_point == contour.first_point) continue;
            EXPECT_FALSE(inside(after.points[contour.first_point], other));
        }
    }
}

TEST(CloseGaps, wider_widths_close_no_less) {
    for (const double width : {0.25, 0.5, 0.7, 1.0, 3.0}) {
        ContourSet set =
            slice_of({{0, box(0, 0, 10, 10)}, {1, box(10.2, 0, 10.6, 10)}, {2, box(10.8, 0, 20, 10)}});
        close_gaps(set, {width});
        EXPECT_GE(shared_length(set, 1), 20) << width;
    }
}

TEST(CloseGaps, area_on_both_sides_of_a_wall_counts) {
    // Two walls that cross in the middle.
    ContourSet set = slice_of(
        {{0, {{0, 0}, {10, 1}, {10, 9}, {0, 10}}}, {1, {{10.2, 0.5}, {20, 0}, {20, 10}, {9.8, 9.5}}}});
    const ConflationStats stats = close_gaps(set, {0.5});
    EXPECT_GT(stats.contours_changed, 0u);
    EXPECT_GT(stats.area_mm2, 0.5);
    EXPECT_LT(stats.area_mm2, 2);
}

TEST(CloseGaps, twice_is_the_same_as_once_on_any_plane) {
    const Plane tilted = make_plane({3, -2, 40}, normalized(Vec3{0.3, -0.2, 0.9}));
    ContourSet once = slice_of(slabs(0.3, 40, 33), tilted);
    const ContourSet before = once;
    close_gaps(once, {0.6});
    EXPECT_GT(shared_length(once, 0), 18.5);
    EXPECT_TRUE(keeps_every_vertex(before, once));
    ContourSet twice = once;
    close_gaps(twice, {0.6});
    EXPECT_EQ(twice.points, once.points);
}

TEST(CloseGaps, widths_of_nothing_change_nothing) {
    const ContourSet before = slice_of(slabs(0.01, 40, 33));
    ContourSet after = before;
    close_gaps(after, {0});
    EXPECT_EQ(after.points, before.points);
}

}  // namespace
}  // namespace anatomesh::close_gaps_test
