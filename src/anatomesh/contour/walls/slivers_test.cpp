#include "anatomesh/contour/walls/slivers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "anatomesh/contour/walls_for_test.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh::slivers_test {
namespace {

using namespace fixtures;

// Two slabs whose common side follows one curve, drawn with so many steps for each.
std::vector<Drawing> one_wall_drawn_twice(int below, int above) {
    return slabs(0, below, above);
}

std::vector<Drawing> crossed_joint() {
    Polygon low{{0, -5}, {40, -5}}, high{{40, 5}, {0, 5}};
    for (int n = 10; n >= 0; --n) low.push_back({4.0 * n, n == 0 || n == 10 ? 0.1 : 0});
    for (int n = 0; n <= 10; ++n) high.push_back({4.0 * n, n == 0 || n == 10 ? 0 : 0.35});
    return {{0, low}, {1, high}};
}

// Of a wall along x: its height there.
double height_at(const Polygon& wall, double x) {
    for (std::size_t n = 0; n + 1 < wall.size(); ++n) {
        const Vec2 a = wall[n], b = wall[n + 1];
        if ((a.x <= x) != (b.x <= x)) return a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x);
    }
    return 0;
}

// Of all sides: vertices of either within this of the other's contour, but not on it.
std::size_t vertices_beside(const ContourSet& set, double width) {
    std::size_t count = 0;
    for (const Contour& own : set.contours) {
        for (const Vec3& v : set.points_of(own)) {
            for (const Contour& other : set.contours) {
                if (other.structure == own.structure) continue;
                const auto q = set.points_of(other);
                double least = width;
                for (std::size_t m = 0; m < q.size(); ++m) {
                    const Vec3 a = q[m], b = q[(m + 1) % q.size()];
                    least = std::min(least, distance_to_segment({v.x, v.y}, {a.x, a.y}, {b.x, b.y}));
                }
                count += least > 0 && least < width;
            }
        }
    }
    return count;
}

TEST(CloseSlivers, a_wall_that_was_drawn_twice_becomes_one_and_no_vertex_moves) {
    for (const auto& [below, above] : {std::pair{14, 11}, {11, 14}, {10, 9}, {13, 13}, {12, 16}, {9, 14}}) {
        const ContourSet before = slice_of(one_wall_drawn_twice(below, above));
        ContourSet after = before;
        const ConflationStats stats = close_slivers(after, {});
        SCOPED_TRACE(testing::Message() << below << " and " << above << " steps");
        EXPECT_TRUE(keeps_every_vertex(before, after));
        EXPECT_LT(stats.widest_mm, 0.4);
        EXPECT_GT(shared_length(after, 0), 16.0);
        EXPECT_LT(vertices_beside(after, 0.1), 3u);
    }
}

TEST(CloseSlivers, nothing_changes_but_what_lies_between_the_contours) {
    for (const auto& [below, above] : {std::pair{14, 11}, {11, 14}, {10, 9}, {13, 12}, {12, 16}, {9, 14}}) {
        const Polygon low = side(0, 20, below, 0, 0.8), high = side(0, 20, above, 0, 0.8);
        double between = 0;
        constexpr int steps = 100000;
        for (int n = 0; n < steps; ++n) {
            const double x = 20 * (n + 0.5) / steps;
            between += 20.0 / steps * std::abs(height_at(low, x) - height_at(high, x));
        }
        ContourSet set = slice_of(one_wall_drawn_twice(below, above));
        const ConflationStats stats = close_slivers(set, {});
        EXPECT_GT(stats.area_mm2, 0.3 * between);
        EXPECT_LE(stats.area_mm2, 1.75 * between) << below << " and " << above << " steps";
    }
    // Long segments beside a small overlap stay where they are.
    const ContourSet before =
        slice_of({{0, box(0, -20, 100, 0)}, {1, {{45, -0.35}, {49, -0.35}, {60, 10}, {40, 10}}}});
    ContourSet after = before;
    const ConflationStats stats = close_slivers(after, {});
    EXPECT_TRUE(keeps_every_vertex(before, after));
    EXPECT_GT(stats.contours_changed, 0u);
    EXPECT_LE(stats.area_mm2, 0.35 * 5);
}

TEST(CloseSlivers, what_the_contours_do_not_enclose_soon_stays_as_drawn) {
    const std::vector<std::vector<Drawing>> layouts{
        // A joint, a wedge that opens from a crossing, contours that touch in one point.
        slabs(0.35, 40, 40),
        slabs(0.05, 40, 40),
        {{0, box(0, 0, 10, 10)}, {1, {{10, 0}, {20, 0}, {20, 10}, {10.3, 10}}}},
        // Two drawings of one thing, and one within the other.
        {{0, {{0, 0}, {10, 0.1}, {20, 0}, {20, 5}, {0, 5}}},
         {1, {{0, 0.05}, {20, 0.05}, {20, 4.9}, {10, 5.1}, {0, 4.9}}}},
        // A joint of 0.35 mm that is crossed at both ends.
        crossed_joint(),
        // A plate of 0.3 mm, and a block that lies over most of its thickness.
        {{0, box(-30, 0, 30, 0.3)}, {1, box(-2, 0.05, 2, 6)}}};
    for (const auto& layout : layouts) {
        const ContourSet before = slice_of(layout);
        ContourSet after = before;
        EXPECT_EQ(close_slivers(after, {}).contours_changed, 0u);
        EXPECT_EQ(after.points, before.points);
    }
}

// A sliver that begins in a vertex of both on another slice's plane is closed; one that the plane passes
// through is not.
TEST(CloseSlivers, what_another_slice_passes_through_stays_but_for_common_vertices_at_its_end) {
    for (const double x : {0.0, 4.0, 8.0, 20.0}) {
        ContourSet set = slice_of({{0, {{0, 0}, {6, -0.1}, {13, -0.1}, {20, 0}, {20, 9}, {0, 9}}},
                                   {1, {{0, 0}, {0, -9}, {20, -9}, {20, 0}, {10, 0.15}}}});
        const Plane other = make_plane({x, 0, 0}, {1, 0, 0});
        set.slices.push_back({other, static_cast<std::uint32_t>(set.contours.size()), 1, "1"});
        std::vector<Vec3> square{{x, -5, -5}, {x, -5, 5}, {x, 5, 5}, {x, 5, -5}};
        set.contours.push_back({0, 1, static_cast<std::uint32_t>(set.points.size()), 4});
        set.points.insert(set.points.end(), square.begin(), square.end());
        const bool at_end = x == 0 || x == 20;
        EXPECT_EQ(close_slivers(set, {}).contours_changed, at_end ? 2u : 0u) << x;
    }
}

TEST(CloseSlivers, what_is_drawn_finely_enough_to_be_meant_stays) {
    // Crossings 6 mm apart with up to 0.3 mm between them, drawn with segments of 1 mm and of 4 mm.
    const auto layout = [](int steps) {
        Polygon low = side(20, 0, steps, 0, 0), high = side(0, 20, steps, 0, 0);
        for (Vec2& p : high) p.y += 0.3 * std::sin(0.5 * p.x + 0.3);
        low.insert(low.end(), {{0, -5}, {20, -5}});
        high.insert(high.end(), {{20, 5}, {0, 5}});
        return slice_of({{0, low}, {1, high}});
    };
    ContourSet fine = layout(20), coarse = layout(5);
    const ContourSet before = fine;
    EXPECT_EQ(close_slivers(fine, {}).contours_changed, 0u);
    EXPECT_EQ(fine.points, before.points);
    EXPECT_GT(close_slivers(coarse, {}).contours_changed, 0u);
}

TEST(CloseSlivers, a_thin_structure_between_two_others_keeps_its_vertices_and_does_not_touch_itself) {
    // 0.2 mm thick; both sides were drawn twice.
    const auto wave = [](double x) { return 0.1 * std::sin(x); };
    Polygon low, thin, high;
    for (int n = 8; n >= 0; --n) low.push_back({2.5 * n, wave(2.5 * n)});
    low.insert(low.end(), {{0, -5}, {20, -5}});
    for (int n = 0; n <= 7; ++n) thin.push_back({20.0 * n / 7, wave(20.0 * n / 7)});
    for (int n = 6; n >= 0; --n) thin.push_back({20.0 * n / 6, 0.2 + wave(20.0 * n / 6)});
    for (int n = 0; n <= 9; ++n) high.push_back({20.0 * n / 9, 0.2 + wave(20.0 * n / 9)});
    high.insert(high.end(), {{20, 5}, {0, 5}});
    for (const auto& order :
         {std::array{0u, 1u, 2u}, {0u, 2u, 1u}, {1u, 0u, 2u}, {1u, 2u, 0u}, {2u, 0u, 1u}, {2u, 1u, 0u}}) {
        std::vector<Drawing> drawings(3);
        drawings[order[0]] = {order[0], low};
        drawings[order[1]] = {order[1], thin};
        drawings[order[2]] = {order[2], high};
        const ContourSet before = slice_of(drawings);
        ContourSet after = before;
        close_slivers(after, {});
        EXPECT_TRUE(keeps_every_vertex(before, after));
        for (const Contour& contour : after.contours) {
            const auto points = after.points_of(contour);
            EXPECT_GT(signed_area(after, contour), 0);
            std::vector<Vec2> polygon;
            for (const Vec3& p : points) polygon.push_back({p.x, p.y});
            for (std::size_t n = 0; n < polygon.size(); ++n) {
                for (std::size_t m = n + 1; m < polygon.size(); ++m) {
                    const bool neighbors = m == n + 1 || (n == 0 && m + 1 == polygon.size());
                    const SegmentContact contact =
                        segment_contact(polygon[n], polygon[(n + 1) % polygon.size()], polygon[m],
                                        polygon[(m + 1) % polygon.size()]);
                    EXPECT_EQ(contact, neighbors ? SegmentContact::touch : SegmentContact::none);
                }
            }
        }
    }
}

TEST(CloseSlivers, twice_is_the_same_as_once_on_any_plane) {
    const Plane tilted = make_plane({3, -2, 40}, normalized(Vec3{0.3, -0.2, 0.9}));
    ContourSet once = slice_of(one_wall_drawn_twice(14, 11), tilted);
    EXPECT_GT(close_slivers(once, {}).contours_changed, 0u);
    ContourSet twice = once;
    EXPECT_EQ(close_slivers(twice, {}).contours_changed, 0u);
    EXPECT_EQ(twice.points, once.points);
}

TEST(CloseSlivers, widths_of_nothing_change_nothing) {
    for (const CloseSliversOptions& options : {CloseSliversOptions{0, 0.1}, {0.4, 0}}) {
        const ContourSet before = slice_of(one_wall_drawn_twice(14, 11));
        ContourSet after = before;
        EXPECT_EQ(close_slivers(after, options).contours_changed, 0u);
        EXPECT_EQ(after.points, before.points);
    }
}

// Where a structure's contour crosses the line of this x, between y = -2 and y = 2.
double crossing_at(const ContourSet& set, std::uint32_t structure, double x) {
    for (const Contour& contour : set.contours_of(set.slices[0])) {
        if (contour.structure != structure) continue;
        const auto p = set.points_of(contour);
        for (std::size_t n = 0; n < p.size(); ++n) {
            const Vec3 a = p[n], b = p[(n + 1) % p.size()];
            if ((a.x <= x) == (b.x <= x)) continue;
            const double y = a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x);
            if (std::abs(y) < 2) return y;
        }
    }
    return 0;
}

// A slice in the plane of this x, with a contour about the wall.
ContourSet with_slice_across(ContourSet set, double x) {
    const ContourSet across = slice_of({{0, box(-5, -5, 5, 5)}}, make_plane({x, 0, 0}, {1, 0, 0}));
    Slice slice = across.slices[0];
    slice.first_contour = static_cast<std::uint32_t>(set.contours.size());
    Contour contour = across.contours[0];
    contour.slice = 1;
    contour.first_point = static_cast<std::uint32_t>(set.points.size());
    set.slices.push_back(slice);
    set.contours.push_back(contour);
    set.points.insert(set.points.end(), across.points.begin(), across.points.end());
    return set;
}

TEST(CloseSlivers, what_another_slice_passes_through_stays) {
    const ContourSet before = slice_of(one_wall_drawn_twice(14, 11));
    ContourSet alone = before;
    close_slivers(alone, {});
    int changed = 0;
    for (double x = 0.5; x < 20; x += 0.37) {
        ContourSet crossed = with_slice_across(before, x);
        close_slivers(crossed, {});
        for (const std::uint32_t structure : {0u, 1u}) {
            const double drawn = crossing_at(before, structure, x);
            changed += std::abs(crossing_at(alone, structure, x) - drawn) > 1e-3;
            EXPECT_NEAR(crossing_at(crossed, structure, x), drawn, 1e-9) << x << ", structure " << structure;
        }
    }
    EXPECT_GT(changed, 10);
}

TEST(CloseSlivers, what_a_third_structure_fills_stays_its_own) {
    // A lens between two slabs, 0.2 mm wide, and what fills it.
    const Polygon low{{0, -5}, {40, -5}, {40, 0}, {25, 0.1}, {20, -0.1}, {15, 0.1}, {0, 0}};
    const Polygon high{{0, 0.05}, {15, 0}, {20, 0.1}, {25, 0}, {40, 0.05}, {40, 5}, {0, 5}};
    const Polygon third{{17.6, 0}, {20, -0.095}, {22.4, 0}, {20, 0.095}};
    const ContourSet before = slice_of({{0, low}, {1, high}, {2, third}});
    ContourSet two = slice_of({{0, low}, {1, high}}), three = before;
    close_slivers(two, {});
    close_slivers(three, {});
    double changed = 0;
    for (const double x : {18.0, 19.0, 21.0, 22.0}) {
        for (const std::uint32_t structure : {0u, 1u}) {
            const double drawn = crossing_at(before, structure, x);
            changed = std::max(changed, std::abs(crossing_at(two, structure, x) - drawn));
            EXPECT_NEAR(crossing_at(three, structure, x), drawn, 1e-9);
        }
    }
    EXPECT_GT(changed, 0.05);
}

}  // namespace
}  // namespace anatomesh::slivers_test
