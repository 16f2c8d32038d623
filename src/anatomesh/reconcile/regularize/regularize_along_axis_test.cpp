#include "anatomesh/reconcile/regularize/regularize_along_axis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::regularize_along_axis_test {
namespace {

using namespace crossing_fixtures;

constexpr int planes = 12;

// A body round the z axis that leaves a channel along it: in the half plane at each angle it begins at a
// distance that `inner` gives for the angle's number (0 to 23, 15 degrees apart).
ContourSet channel(const std::function<double(int)>& inner, int count = planes) {
    ContourSet set;
    set.structures.push_back({1, "body", {200, 200, 200}});
    for (int n = 0; n < count; ++n) {
        const double angle = std::numbers::pi * n / planes;
        const Vec3 out{std::cos(angle), std::sin(angle), 0};
        const Plane plane = make_plane({}, {-std::sin(angle), std::cos(angle), 0});
        const auto slice = static_cast<std::uint32_t>(set.slices.size());
        set.slices.push_back({plane, static_cast<std::uint32_t>(set.contours.size()), 2, std::to_string(n)});
        for (const int side : {0, 1}) {
            const double r = inner(n + side * planes);
            Ring ring;
            for (const Vec2 q : Ring{{r, -10}, {20, -10}, {20, 10}, {r, 10}, {r, 3}, {r, -3}})
                ring.push_back(plane.to_plane((side == 0 ? q.x : -q.x) * out + Vec3{0, 0, q.y}));
            if (signed_area(ring) < 0) std::reverse(ring.begin(), ring.end());
            set.contours.push_back({0, slice, static_cast<std::uint32_t>(set.points.size()), 6});
            for (const Vec2 q : ring) set.points.push_back(plane.to_space(q));
        }
    }
    return set;
}

// Of the nearest point in a half plane.
double distance_at(const ContourSet& set, int half) {
    double least = 1e9;
    const double angle = std::numbers::pi * half / planes;
    const Vec3 out{std::cos(angle), std::sin(angle), 0};
    for (const Contour& contour : set.contours_of(set.slices[half % planes])) {
        for (const Vec3& p : set.points_of(contour)) {
            if (dot(p, out) > 0) least = std::min(least, dot(p, out));
        }
    }
    return least;
}

AlongAxisStats regularize(ContourSet& set, const ContourSet& drawn_set, double bound = 10) {
    OriginalPositions drawn = original_positions(drawn_set);
    const AlongAxisStats stats =
        regularize_along_axis(set, drawn, AlongAxisBounds(set.slices.size(), bound), {1.5, 70, 10});
    EXPECT_EQ(drawn.at.size(), set.points.size());
    for (const Slice& slice : set.slices)
        EXPECT_TRUE(slice_faults(plane_rings(set, slice), set.exclusive).empty());
    return stats;
}

// At a distance r between neighbours at a and b, 15 degrees away.
double angle_between(double r, double a, double b) {
    const double turn = std::numbers::pi / planes;
    const Vec2 p{a * std::cos(turn) - r, -a * std::sin(turn)}, q{b * std::cos(turn) - r, b * std::sin(turn)};
    return std::acos(dot(p, q) / length(p) / length(q)) * 180 / std::numbers::pi;
}

TEST(RegularizeAlongAxis, a_slit_and_a_fin_beside_the_line_go_as_far_as_they_are_sharp) {
    for (const double own : {0.05, 0.2, 0.4, 1.4}) {
        for (const int half : {3, 17}) {
            const double others = own < 1 ? 1 : 0.5;
            ContourSet set = channel([&](int n) { return n == half ? own : others; });
            const ContourSet before = set;
            ASSERT_LT(angle_between(own, others, others), 70);
            const AlongAxisStats stats = regularize(set, before);
            EXPECT_GT(stats.points, 0u);
            const double now = distance_at(set, half);
            EXPECT_GE(angle_between(now, others, others), 69.9) << own;
            // No further than to the chord between its neighbours.
            const double chord = others * std::cos(std::numbers::pi / planes);
            EXPECT_GT((now - own) * (chord - own), 0);
            EXPECT_LE(std::abs(now - own), std::abs(chord - own));
            EXPECT_NEAR(stats.farthest_mm, std::abs(now - own), 1e-9);
            for (int n = 0; n < 2 * planes; ++n) {
                if (n != half) {
                    EXPECT_EQ(distance_at(set, n), distance_at(before, n));
                }
            }
        }
    }
}

// On it, or over it by rounding: it is a stretch as any other.
TEST(RegularizeAlongAxis, a_fin_that_begins_on_the_line_goes_too) {
    const int half = 3;
    const double angle = std::numbers::pi * half / planes;
    const Vec3 out{std::cos(angle), std::sin(angle), 0};
    for (const double end : {0.0, 1e-15, -1e-15}) {
        ContourSet set = channel([&](int n) { return n == half ? 0.1 : 1.0; });
        for (Vec3& p : set.points) {
            if (p.z == 10 && std::abs(dot(p, out) - 0.1) < 1e-9) p = p + (end - dot(p, out)) * out;
        }
        const ContourSet before = set;
        regularize(set, before);
        int between = 0;
        for (const Vec3& p : set.points) {
            if (p.z < 3.5 || p.z > 9.5) continue;
            ++between;
            EXPECT_GT(dot(p, out), 0.2);
        }
        EXPECT_GT(between, 0) << end;
    }
}

TEST(RegularizeAlongAxis, slopes_over_several_planes_and_what_is_far_from_the_line_keep_their_bits) {
    const std::function<double(int)> shapes[] = {
        [](int) { return 0.1; }, [](int n) { return 0.5 + 0.3 * std::sin(n * std::numbers::pi / planes); },
        [](int n) { return n % 2 == 0 ? 5.0 : 3.0; }};
    for (const auto& shape : shapes) {
        ContourSet set = channel(shape);
        const ContourSet before = set;
        EXPECT_EQ(regularize(set, before).points, 0u);
        EXPECT_EQ(set.points, before.points);
    }
}

TEST(RegularizeAlongAxis, three_planes_are_no_line_of_many) {
    ContourSet set = channel([](int n) { return n == 1 ? 0.1 : 1.0; }, 3);
    const ContourSet before = set;
    EXPECT_EQ(regularize(set, before).points, 0u);
    EXPECT_EQ(set.points, before.points);
}

TEST(RegularizeAlongAxis, what_rises_and_falls_by_turns_is_settled_and_stays_off_the_line) {
    ContourSet set = channel([](int n) { return n % 2 == 0 ? 0.05 : 1.2; });
    const ContourSet before = set;
    EXPECT_GT(regularize(set, before).points, 0u);
    for (int n = 0; n < 2 * planes; ++n) {
        const double r = distance_at(set, n), a = distance_at(set, (n + 1) % (2 * planes)),
                     b = distance_at(set, (n + 2 * planes - 1) % (2 * planes));
        EXPECT_GT(r, 0.02);
        EXPECT_GE(angle_between(r, a, b), 55);
    }
}

TEST(RegularizeAlongAxis, no_vertex_moves_further_than_it_may) {
    ContourSet set = channel([](int n) { return n == 4 ? 0.1 : 1.0; });
    const ContourSet before = set;
    const AlongAxisStats stats = regularize(set, before, 0.1);
    EXPECT_GT(stats.points, 0u);
    EXPECT_LE(stats.farthest_mm, 0.1 + 1e-12);
    EXPECT_NEAR(distance_at(set, 4), 0.2, 1e-9);
    // Slices that agreed as drawn keep theirs.
    ContourSet exact = before;
    EXPECT_EQ(regularize(exact, before, 0).points, 0u);
    EXPECT_EQ(exact.points, before.points);
}

}  // namespace
}  // namespace anatomesh::regularize_along_axis_test
