#include "anatomesh/contour/close_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "anatomesh/contour/drawn_slice_for_test.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {
namespace {

using namespace fixtures;
using Edge = std::pair<Vec3, Vec3>;

// Edges of one structure that another has the other way round, and their length.
double shared_length(const ContourSet& set, std::uint32_t structure) {
    double sum = 0;
    for (const Contour& own : set.contours) {
        if (own.structure != structure) continue;
        const auto p = set.points_of(own);
        for (std::size_t n = 0; n < p.size(); ++n) {
            const Vec3 a = p[n], b = p[(n + 1) % p.size()];
            for (const Contour& other : set.contours) {
                if (other.structure == structure) continue;
                const auto q = set.points_of(other);
                for (std::size_t m = 0; m < q.size(); ++m)
                    if (q[m] == b && q[(m + 1) % q.size()] == a) sum += length(b - a);
            }
        }
    }
    return sum;
}

bool keeps_every_vertex(const ContourSet& before, const ContourSet& after) {
    if (before.contours.size() != after.contours.size()) return false;
    for (const Contour& old : before.contours) {
        const bool found = std::any_of(after.contours.begin(), after.contours.end(), [&](const Contour& now) {
            if (now.structure != old.structure) return false;
            // In the same order round.
            const auto p = before.points_of(old), q = after.points_of(now);
            const auto start = std::find(q.begin(), q.end(), p[0]);
            if (start == q.end()) return false;
            std::size_t at = 0;
            for (std::size_t k = 0; k < q.size() && at < p.size(); ++k)
                at += q[(static_cast<std::size_t>(start - q.begin()) + k) % q.size()] == p[at];
            return at == p.size();
        });
        if (!found) return false;
    }
    return true;
}

Polygon box(double x0, double y0, double x1, double y1) {
    return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

// A side from (x0, y) to (x1, y) in so many steps, at heights y + wave sin.
Polygon side(double x0, double x1, int steps, double y, double wave) {
    Polygon points;
    for (int n = 0; n <= steps; ++n) {
        const double x = x0 + (x1 - x0) * n / steps;
        points.push_back({x, y + wave * std::sin(0.7 * x)});
    }
    return points;
}

// Two slabs over each other with a gap (or, below 0, an overlap) between their sides of so many steps each.
std::vector<Drawing> slabs(double gap, int below, int above) {
    Polygon low = side(20, 0, below, 0, 0.8), high = side(0, 20, above, gap, 0.8);
    low.push_back({0, -5});
    low.push_back({20, -5});
    high.push_back({20, 5});
    high.push_back({0, 5});
    return {{0, low}, {1, high}};
}

TEST(CloseGaps, sides_that_run_within_the_width_become_one_and_no_vertex_moves) {
    for (const double gap : {0.4, 0.1, 0.0, -0.1, -0.4}) {
        for (const auto& [below, above] :
             {std::pair{40, 40}, {40, 37}, {37, 40}, {40, 20}, {20, 41}, {80, 20}}) {
            const ContourSet before = slice_of(slabs(gap, below, above));
            ContourSet after = before;
            const CloseGapsStats stats = close_gaps(after, {0.7});
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
        const CloseGapsStats stats = close_gaps(after, {0.5});
        EXPECT_EQ(after.points, before.points);
        EXPECT_EQ(stats.contours_changed, 0u);
        EXPECT_EQ(stats.area_mm2, 0);
    }
}

TEST(CloseGaps, the_area_that_changes_hands_is_that_of_the_gap) {
    ContourSet set = slice_of({{0, box(0, 0, 10, 10)}, {1, box(10.25, 0, 20, 10)}});
    const CloseGapsStats stats = close_gaps(set, {0.3});
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
    const CloseGapsStats stats = close_gaps(after, {0.35});
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

double signed_area(const ContourSet& set, const Contour& contour) {
    const auto p = set.points_of(contour);
    double twice = 0;
    for (std::size_t n = 1; n + 1 < p.size(); ++n) twice += cross(p[n] - p[0], p[n + 1] - p[0]).z;
    return 0.5 * twice;
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
    const CloseGapsStats stats = close_gaps(set, {0.5});
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

// Two slabs whose common side follows one curve, drawn with so many steps for each.
std::vector<Drawing> one_wall_drawn_twice(int below, int above) {
    return slabs(0, below, above);
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
        const CloseGapsStats stats = close_slivers(after, {});
        SCOPED_TRACE(testing::Message() << below << " and " << above << " steps");
        EXPECT_TRUE(keeps_every_vertex(before, after));
        EXPECT_LT(stats.widest_mm, 0.4);
        EXPECT_GT(shared_length(after, 0), 16.0);
        EXPECT_LT(vertices_beside(after, 0.1), 3u);
    }
}

TEST(CloseSlivers, what_does_not_cross_again_and_again_stays_as_drawn) {
    const std::vector<std::vector<Drawing>> layouts{
        // A joint, a wedge that opens from a crossing, contours that touch in one point.
        slabs(0.35, 8, 5),
        slabs(0.05, 40, 40),
        {{0, {{0, 0}, {10, 1}, {10, 9}, {0, 10}}}, {1, {{10.2, 0.5}, {20, 0}, {20, 10}, {9.8, 9.5}}}},
        {{0, box(0, 0, 10, 10)}, {1, {{10, 0}, {20, 0}, {20, 10}, {10.3, 10}}}},
        // Two drawings of one thing, and one within the other.
        {{0, {{0, 0}, {10, 0.1}, {20, 0}, {20, 5}, {0, 5}}},
         {1, {{0, 0.05}, {20, 0.05}, {20, 4.9}, {10, 5.1}, {0, 4.9}}}},
        // A lone vertex that reaches into the neighbour.
        {{0, box(0, 0, 10, 10)}, {1, {{9.8, 5}, {15, 0}, {15, 10}}}}};
    for (const auto& layout : layouts) {
        const ContourSet before = slice_of(layout);
        ContourSet after = before;
        EXPECT_EQ(close_slivers(after, {}).contours_changed, 0u);
        EXPECT_EQ(after.points, before.points);
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

}  // namespace
}  // namespace anatomesh
