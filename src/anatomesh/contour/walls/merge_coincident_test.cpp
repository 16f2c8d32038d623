#include "anatomesh/contour/walls/merge_coincident.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "anatomesh/contour/drawn_slice_for_test.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh::merge_coincident_test {
namespace {

using namespace fixtures;

const Plane tilted = make_plane({3, -2, 40}, normalized(Vec3{0.3, -0.2, 0.9}));

Polygon flat(const ContourSet& set, std::size_t contour) {
    Polygon polygon;
    for (const Vec3& p : set.points_of(set.contours[contour]))
        polygon.push_back(set.slices[0].plane.to_plane(p));
    return polygon;
}

double perimeter(const Polygon& p) {
    double sum = 0;
    for (std::size_t n = 0; n < p.size(); ++n) sum += length(p[(n + 1) % p.size()] - p[n]);
    return sum;
}

bool is_simple(const Polygon& p) {
    for (std::size_t i = 0; i < p.size(); ++i) {
        for (std::size_t j = i + 1; j < p.size(); ++j) {
            const bool joined = j == i + 1 || (i == 0 && j + 1 == p.size());
            const SegmentContact contact =
                segment_contact(p[i], p[(i + 1) % p.size()], p[j], p[(j + 1) % p.size()]);
            if (contact == SegmentContact::overlap || (!joined && contact != SegmentContact::none))
                return false;
        }
    }
    return true;
}

// Length of edges that two structures both have, either way round.
double common_length(const ContourSet& set, std::size_t one, std::size_t other) {
    const auto p = set.points_of(set.contours[one]), q = set.points_of(set.contours[other]);
    double sum = 0;
    for (std::size_t n = 0; n < p.size(); ++n) {
        const Vec3 a = p[n], b = p[(n + 1) % p.size()];
        for (std::size_t m = 0; m < q.size(); ++m) {
            const Vec3 c = q[m], d = q[(m + 1) % q.size()];
            if ((a == c && b == d) || (a == d && b == c)) sum += length(b - a);
        }
    }
    return sum;
}

bool has_edge(const ContourSet& set, std::size_t contour, Vec3 a, Vec3 b) {
    const auto p = set.points_of(set.contours[contour]);
    for (std::size_t n = 0; n < p.size(); ++n) {
        const Vec3 c = p[n], d = p[(n + 1) % p.size()];
        if ((a == c && b == d) || (a == d && b == c)) return true;
    }
    return false;
}

// The line from x = 0 to 20 at a height, in steps as random as the noise about it.
Polygon noisy_line(std::mt19937_64& random, double height, double noise) {
    std::uniform_real_distribution<double> step(0.3, 1.5), off(-noise, noise);
    Polygon line;
    for (double x = 0.1 + step(random); x < 19.5; x += step(random))
        line.push_back({x, height + off(random)});
    return line;
}

// A box above the line with its lower side along it; as high as `top` (below the line where that is
// negative).
Polygon box_along(const Polygon& line, double left, double right, double top) {
    Polygon polygon{{left, line.front().y}};
    polygon.insert(polygon.end(), line.begin(), line.end());
    polygon.insert(polygon.end(), {{right, line.back().y}, {right, top}, {left, top}});
    if (top < line.front().y) std::reverse(polygon.begin(), polygon.end());
    return polygon;
}

// Noise up to 0.009 mm on either makes copies of one line up to 0.018 mm apart.
const MergeCoincidentOptions copies{.width_mm = 0.02, .share_of_segment = 0.05};

class CopiedLines : public testing::TestWithParam<int> {};

TEST_P(CopiedLines, have_the_same_edges_and_nothing_runs_farther_off_than_the_width) {
    std::mt19937_64 random(static_cast<std::uint64_t>(GetParam()));
    for (const double noise : {0.0, 0.0001, 0.001, 0.004, 0.009}) {
        for (const bool nested : {true, false}) {
            const Polygon one = noisy_line(random, 0, noise), other = noisy_line(random, 0, noise);
            const ContourSet before = slice_of(
                {{0, box_along(one, -1, 21, 9)}, {1, box_along(other, 0.03, 19.97, nested ? 6 : -6)}},
                tilted);
            ContourSet after = before;
            const MergeCoincidentStats stats = merge_coincident(after, copies);
            SCOPED_TRACE(testing::Message() << "noise " << noise << (nested ? ", nested" : ", side by side"));
            EXPECT_LT(stats.widest_mm, copies.width_mm);
            EXPECT_GT(stats.vertices_taken, one.size());
            // All between the outermost vertices on the line.
            EXPECT_GT(common_length(after, 0, 1), 19.5 - 3);
            for (const std::size_t c : {0u, 1u}) {
                const Polygon drawn = flat(before, c), led = flat(after, c);
                EXPECT_TRUE(is_simple(led));
                EXPECT_LE(std::abs(signed_area(led) - signed_area(drawn)),
                          copies.width_mm * perimeter(drawn));
                EXPECT_GT(signed_area(led) * signed_area(drawn), 0);
            }
            ContourSet twice = after;
            EXPECT_EQ(merge_coincident(twice, copies).widest_mm, 0);
            EXPECT_EQ(twice.points, after.points);
        }
    }
}

TEST_P(CopiedLines, farther_apart_than_the_width_stay_as_drawn) {
    std::mt19937_64 random(static_cast<std::uint64_t>(GetParam()));
    for (const double apart : {1.005 * copies.width_mm, 0.05, 0.3}) {
        for (const bool nested : {true, false}) {
            const Polygon one = noisy_line(random, 0, 0),
                          other = noisy_line(random, nested ? apart : -apart, 0);
            const ContourSet before =
                slice_of({{0, box_along(one, -1, 21, 9)}, {1, box_along(other, 0.5, 19.5, nested ? 6 : -6)}});
            ContourSet after = before;
            EXPECT_EQ(merge_coincident(after, copies).contours_changed, 0u);
            EXPECT_EQ(after.points, before.points);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, CopiedLines, testing::Range(0, 20));

Polygon ring_of(double radius, int steps, double turn, Vec2 centre = {}) {
    Polygon polygon;
    for (int n = 0; n < steps; ++n) {
        const double angle = turn + 2 * std::numbers::pi * n / steps;
        polygon.push_back(centre + Vec2{radius * std::cos(angle), radius * std::sin(angle)});
    }
    return polygon;
}

TEST(MergeCoincident, vertices_of_different_structures_within_the_width_become_one) {
    for (const double off : {1e-4, 0.003, 0.012}) {
        Polygon copy = ring_of(10, 40, 0);
        for (std::size_t n = 0; n < copy.size(); ++n)
            copy[n] = copy[n] + off * Vec2{std::cos(3.0 * static_cast<double>(n)),
                                           std::sin(3.0 * static_cast<double>(n))};
        const ContourSet before = slice_of({{0, ring_of(10, 40, 0)}, {1, copy}});
        ContourSet after = before;
        const MergeCoincidentStats stats = merge_coincident(after, {});
        EXPECT_EQ(stats.vertices_moved, 40u) << off;
        EXPECT_NEAR(stats.widest_mm, off, 1e-12);
        EXPECT_NEAR(common_length(after, 0, 1), perimeter(ring_of(10, 40, 0)), 1e-9);
        // The first structure's stay where they are.
        EXPECT_EQ(flat(after, 0), flat(before, 0));
    }
}

TEST(MergeCoincident, a_contour_that_crosses_another_beside_a_vertex_goes_through_it) {
    ContourSet set =
        slice_of({{0, {{0, 0}, {10, 0}, {10, 10}, {0, 10}}}, {1, {{5, 0.01}, {9, -3}, {12, 4}}}});
    const MergeCoincidentStats stats = merge_coincident(set, {});
    EXPECT_EQ(stats.vertices_taken, 1u);
    EXPECT_NEAR(stats.widest_mm, 0.01, 1e-12);
    EXPECT_NEAR(stats.area_mm2, 0.5 * 10 * 0.01, 1e-9);
    EXPECT_EQ(set.contours[0].point_count, 5u);
}

// A third contour's vertex may lie within the width of one of two copies of a segment and not of the other.
TEST(MergeCoincident, what_two_share_is_led_through_a_vertex_of_a_third_by_both_or_by_none) {
    for (const double off : {0.003, 0.009, 0.018, 0.025, 0.032, 0.045}) {
        const double copy = 0.015;  // height of the second's line; the third's vertex lies so far below it
        ContourSet set = slice_of({{0, {{0, 0}, {10, 0}, {10, 10}, {0, 10}}},
                                   {1, {{0, copy}, {10, copy}, {10, 6}, {0, 6}}},
                                   {2, {{5, copy - off}, {8, -3}, {2, -3}}}},
                                  tilted);
        merge_coincident(set, {.width_mm = 0.02, .share_of_segment = 0.05});
        const Vec3 p = tilted.to_space({0, 0}), q = tilted.to_space({10, 0}),
                   v = tilted.to_space({5, copy - off});
        const bool both = off < 0.02;
        for (const std::size_t c : {0u, 1u}) {
            EXPECT_EQ(has_edge(set, c, p, v) && has_edge(set, c, v, q), both) << off;
            EXPECT_EQ(has_edge(set, c, p, q), !both) << off;
        }
    }
}

// Two slices that cross in the x axis, in one set.
ContourSet crossing(const std::vector<Drawing>& one, const std::vector<Drawing>& other) {
    ContourSet set = slice_of(one, make_plane({}, {0, 0, 1}));
    const ContourSet second = slice_of(other, make_plane({}, {0, 1, 0}));
    set.slices.push_back(second.slices[0]);
    set.slices[1].first_contour = static_cast<std::uint32_t>(set.contours.size());
    for (Contour contour : second.contours) {
        contour.slice = 1;
        contour.first_point += static_cast<std::uint32_t>(set.points.size());
        set.contours.push_back(contour);
    }
    set.points.insert(set.points.end(), second.points.begin(), second.points.end());
    return set;
}

// In coordinates along the axis and across it, on either plane.
Polygon on_plane(const Plane& plane, const Polygon& drawn) {
    Polygon result;
    for (const Vec2 p : drawn)
        result.push_back(plane.to_plane(p.x * Vec3{1, 0, 0} + p.y * cross(plane.normal, Vec3{1, 0, 0})));
    return result;
}

// How many slices' contour of a structure has a point of the axis.
int slices_with(const ContourSet& set, std::uint32_t structure, double x) {
    int count = 0;
    for (const Contour& contour : set.contours) {
        if (contour.structure != structure) continue;
        const auto points = set.points_of(contour);
        count += std::find(points.begin(), points.end(), Vec3{x, 0, 0}) != points.end();
    }
    return count;
}

TEST(MergeCoincident, vertices_that_slices_have_in_common_are_shared_on_all_of_them_or_on_none) {
    const Plane planes[] = {make_plane({}, {0, 0, 1}), make_plane({}, {0, 1, 0})};
    const Polygon left{{0, -5}, {10, -5}, {10, 0}, {10, 5}, {0, 5}};
    const auto right = [](double x, double corner) {  // a corner on the axis, or beside it
        return Polygon{{x, corner}, {20, -6}, {20, 6}};
    };
    const Polygon straight{{10.01, -4}, {20, -4}, {20, 4}, {10.01, 4}};  // beside the point on the axis
    const auto shared = [&](const Polygon& one, const Polygon& other) {
        ContourSet set = crossing({{0, on_plane(planes[0], left)}, {1, on_plane(planes[0], one)}},
                                  {{0, on_plane(planes[1], left)}, {1, on_plane(planes[1], other)}});
        const ContourSet before = set;
        merge_coincident(set, {});
        EXPECT_EQ(slices_with(set, 0, 10), 2);  // it moves on no slice
        if (slices_with(set, 1, 10) == 0) {
            for (const std::size_t c : {1u, 3u}) {  // the second structure stays as drawn
                const auto now = set.points_of(set.contours[c]), drawn = before.points_of(before.contours[c]);
                EXPECT_TRUE(std::equal(now.begin(), now.end(), drawn.begin(), drawn.end()));
            }
        }
        return slices_with(set, 1, 10);
    };
    EXPECT_EQ(shared(right(10.01, 0), right(10.01, 0)), 2);         // common vertices of both become one
    EXPECT_EQ(shared(right(10.01, 0.01), right(10.02, -0.01)), 2);  // each slice's own vertex moves onto it
    EXPECT_EQ(shared(straight, straight), 2);                       // segments of both are led through it
    EXPECT_EQ(shared(straight, right(10.01, 0.01)), 2);
    // The second slice's is too far away, and what the first could do it leaves.
    EXPECT_EQ(shared(right(10.01, 0.01), right(10.2, 0)), 0);
    EXPECT_EQ(shared(straight, right(10.2, 0)), 0);
    EXPECT_EQ(shared(straight, Polygon{{14, -4}, {20, -4}, {20, 4}}), 0);
}

TEST(MergeCoincident, contours_of_one_structure_never_come_to_touch) {
    // A slit of one structure, narrower than the width, with another structure's edge within it.
    const Polygon slit{{0, 0}, {10, 0}, {10, 5}, {2, 5}, {2, 5.012}, {10, 5.012}, {10, 10}, {0, 10}};
    const Polygon between{{5, 5.006}, {20, 4}, {20, 6}};
    ContourSet set = slice_of({{0, slit}, {1, between}});
    merge_coincident(set, {});
    for (const std::size_t c : {0u, 1u}) EXPECT_TRUE(is_simple(flat(set, c)));
    EXPECT_GT(signed_area(flat(set, 0)), 99);
}

TEST(MergeCoincident, contours_that_cross_beside_each_other_in_space_meet) {
    // Two that share an edge, and a third across it; their points on the plane, or off it by a hundredth.
    for (const double off : {0.0, 0.01}) {
        ContourSet set = slice_of({{0, {{-5, -5}, {0, -5}, {0, 5}, {-5, 5}}},
                                   {1, {{0, -5}, {5, -5}, {5, 5}, {0, 5}}},
                                   {2, {{-2, -1}, {2, -1}, {2, 1}, {-2, 1}}}});
        for (Vec3& p : set.points) p.z += std::abs(p.x) == 2 ? off : 0;
        const ContourSet before = set;
        const MergeCoincidentStats stats = merge_coincident(set, {});
        if (off == 0) {
            EXPECT_EQ(set.points, before.points);
            continue;
        }
        EXPECT_EQ(stats.vertices_taken, 6u);
        EXPECT_EQ(stats.contours_changed, 3u);
        EXPECT_DOUBLE_EQ(stats.widest_mm, 0.005);
        EXPECT_LT(stats.area_mm2, 1e-12);
        for (const double y : {-1.0, 1.0}) {
            for (std::size_t c = 0; c < 3; ++c) {
                const auto points = set.points_of(set.contours[c]);
                EXPECT_EQ(std::count(points.begin(), points.end(), Vec3{0, y, before.points[0].z + 0.005}),
                          1);
            }
        }
        for (const Vec3& p : before.points)
            EXPECT_NE(std::find(set.points.begin(), set.points.end(), p), set.points.end());
    }
}

// Three that cross nearly in one point: one vertex for all, and no edge as short as they are apart.
TEST(MergeCoincident, contours_that_cross_beside_one_point_share_a_vertex) {
    for (const double apart : {0.0, 1e-9, 1e-7, 1e-3}) {
        ContourSet set = slice_of({{0, {{-5, -5}, {0, -5}, {0, 5}, {-5, 5}}},
                                   {1, {{-4, -4}, {6 + apart, 6}, {-4, 6}}},
                                   {2, {{-3, 0}, {4, 0}, {4, 8}, {-3, 8}}}});
        // The second passes by the first's and the third's crossing at (0, 0).
        for (std::size_t n = 0; n < set.points.size(); ++n) set.points[n].z += 0.008 * (n % 3);
        merge_coincident(set, {});
        for (std::size_t c = 0; c < 3; ++c) {
            const auto points = set.points_of(set.contours[c]);
            for (std::size_t n = 0; n < points.size(); ++n)
                EXPECT_GT(length(points[(n + 1) % points.size()] - points[n]), 0.05) << apart;
            EXPECT_TRUE(is_simple(flat(set, c)));
        }
    }
}

// Not beside the end of a segment: a contour that ends there goes through it by itself.
TEST(MergeCoincident, crossings_beside_a_vertex_get_none) {
    ContourSet set =
        slice_of({{0, {{-5, -5}, {0, -5}, {0, 5}, {-5, 5}}}, {1, {{-2, 4.9}, {2, 4.99}, {2, 7}, {-2, 7}}}});
    for (Vec3& p : set.points) p.z += std::abs(p.x) == 2 ? 0.01 : 0;
    const MergeCoincidentStats stats = merge_coincident(set, {0.1, 0.5});
    EXPECT_EQ(stats.vertices_moved, 0u);
    for (std::size_t c = 0; c < 2; ++c) EXPECT_LE(set.points_of(set.contours[c]).size(), 5u);
}

TEST(MergeCoincident, small_drawings_are_not_copies_of_each_other) {
    // Rings a hundredth of a millimetre apart, of segments as short as that.
    const ContourSet before = slice_of({{0, ring_of(0.2, 40, 0)}, {1, ring_of(0.19, 40, 0)}});
    ContourSet after = before;
    const MergeCoincidentStats stats = merge_coincident(after, {});
    EXPECT_LT(stats.width_mm, 0.002);
    EXPECT_EQ(after.points, before.points);
}

TEST(MergeCoincident, the_same_for_other_directions_of_the_plane_and_none_without_a_width) {
    const std::vector<Drawing> drawings{
        {0, ring_of(10, 40, 0)}, {1, ring_of(10, 33, 0.1)}, {2, ring_of(10, 40, 1e-4)}};
    ContourSet up = slice_of(drawings), none = up;
    EXPECT_EQ(merge_coincident(none, {0, 0.05}).contours_changed, 0u);
    EXPECT_EQ(none.points, slice_of(drawings).points);
    ContourSet down = up;
    down.slices[0].plane = make_plane({}, {0, 0, -1});
    merge_coincident(up, {});
    merge_coincident(down, {});
    EXPECT_EQ(up.points, down.points);
    EXPECT_GT(common_length(up, 0, 2), 62);
}

}  // namespace
}  // namespace anatomesh::merge_coincident_test
