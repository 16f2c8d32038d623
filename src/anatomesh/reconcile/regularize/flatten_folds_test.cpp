#include "anatomesh/reconcile/regularize/flatten_folds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::flatten_folds_test {
namespace {

using crossing_fixtures::Ring;

// A square with a notch in its right side, `width` wide and `depth` deep.
Ring notched(double width, double depth) {
    Ring ring{{0, 0}, {40, 0}, {40, 20 - 0.5 * width}};
    for (const double s : {0.25, 0.5, 0.75}) ring.push_back({40 - s * depth, 20 - 0.5 * width});
    ring.push_back({40 - depth, 20});
    for (const double s : {0.75, 0.5, 0.25}) ring.push_back({40 - s * depth, 20 + 0.5 * width});
    ring.push_back({40, 20 + 0.5 * width});
    ring.push_back({40, 40});
    ring.push_back({0, 40});
    return ring;
}

// A slice with `now`, whose points were drawn where `drawn` has them.
struct Case {
    ContourSet set;
    std::vector<MovedPoint> moved;
    Case(const Plane& plane, const Ring& now, const Ring& drawn) {
        crossing_fixtures::add_slice(set, plane, now);
        for (std::size_t k = 0; k < now.size(); ++k)
            moved.push_back({plane.to_space(now[k]), plane.to_space(drawn[k])});
    }
};

double area(const ContourSet& set) {
    const Plane& plane = set.slices[0].plane;
    double sum = 0;
    const auto points = set.points_of(set.contours[0]);
    for (std::size_t k = 0; k < points.size(); ++k)
        sum += 0.5 * cross(plane.to_plane(points[k]), plane.to_plane(points[(k + 1) % points.size()]));
    return sum;
}

TEST(FlattenFolds, C25_a_notch_that_closed_goes_and_the_rest_stays) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int n = 0; n < 50; ++n) {
        const double depth = 6 + 4 * unit(random), width = 0.02 + 0.2 * (1 + unit(random));
        const Plane plane =
            make_plane(10 * Vec3{unit(random), unit(random), unit(random)},
                       normalized(Vec3{1 + unit(random), 2 * unit(random), 2 * unit(random)}));
        Case one(plane, notched(width, depth), notched(8, 10));
        const FoldStats stats = flatten_folds(one.set, one.moved, {40});
        EXPECT_EQ(stats.folds, 1u);
        EXPECT_EQ(stats.vertices, 7u);
        EXPECT_NEAR(stats.highest_mm, depth, 0.2);
        EXPECT_NEAR(area(one.set), 1600, 1e-6);
        EXPECT_EQ(one.set.contours[0].point_count, 6u);
    }
}

TEST(FlattenFolds, C25_what_was_drawn_narrow_or_is_wide_stays) {
    const Plane plane = make_plane({0, 0, 0}, {0, 0, 1});
    // Drawn so; moved as a whole.
    Ring shifted = notched(0.2, 8);
    for (Vec2& q : shifted) q = q + Vec2{3, 1};
    Case same(plane, notched(0.2, 8), shifted);
    EXPECT_EQ(flatten_folds(same.set, same.moved, {40}).folds, 0u);
    EXPECT_EQ(same.set.points.size(), shifted.size());
    // Still open.
    Case open(plane, notched(5, 8), notched(9, 8));
    EXPECT_EQ(flatten_folds(open.set, open.moved, {40}).folds, 0u);
}

TEST(FlattenFolds, a_point_that_another_slice_has_too_stays) {
    const Plane plane = make_plane({0, 0, 0}, {0, 0, 1});
    Case one(plane, notched(0.2, 8), notched(8, 8));
    const Plane across = make_plane({32, 20, 0}, {1, 0, 0});
    const Vec3 tip{32, 20, 0};
    Ring other;
    for (const Vec3 p : {tip, Vec3{32, 25, 5}, Vec3{32, 20, 10}, Vec3{32, 15, 5}})
        other.push_back(across.to_plane(p));
    crossing_fixtures::add_slice(one.set, across, other);
    for (Vec3& p : one.set.points) {
        if (length(p - tip) < 1e-9) p = tip;
    }
    flatten_folds(one.set, one.moved, {40});
    const auto points = one.set.points_of(one.set.contours[0]);
    EXPECT_NE(std::find(points.begin(), points.end(), tip), points.end());
}

// A ring of corners as blunt as 171 degrees, of which the first one stands out by `height`.
Ring with_spike(double height) {
    Ring ring;
    for (int k = 0; k < 40; ++k) {
        const double turn = 2 * std::numbers::pi * k / 40, r = k == 0 ? 10 + height : 10;
        ring.push_back({r * std::cos(turn), r * std::sin(turn)});
    }
    return ring;
}

TEST(FlattenFolds, a_sharp_corner_that_was_none_goes) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const double height : {-6.0, -3.5, 3.5, 6.0}) {
        const Plane plane =
            make_plane(10 * Vec3{unit(random), unit(random), unit(random)},
                       normalized(Vec3{1 + unit(random), 2 * unit(random), 2 * unit(random)}));
        Case one(plane, with_spike(height), with_spike(0.3 * unit(random)));
        const FoldStats stats = flatten_folds(one.set, one.moved, {40});
        EXPECT_EQ(stats.spikes, 1u) << height;
        EXPECT_EQ(stats.folds, 0u);
        EXPECT_EQ(stats.vertices, 1u);
        EXPECT_NEAR(stats.highest_mm, std::abs(height), 0.2);
        EXPECT_EQ(one.set.contours[0].point_count, 39u);
    }
}

TEST(FlattenFolds, a_corner_that_is_blunt_or_was_drawn_sharp_stays) {
    const Plane plane = make_plane({0, 0, 0}, {0, 0, 1});
    Case blunt(plane, with_spike(0.9), with_spike(0));
    EXPECT_EQ(flatten_folds(blunt.set, blunt.moved, {40}).spikes, 0u);
    Ring shifted = with_spike(3.5);
    for (Vec2& q : shifted) q = q + Vec2{3, 1};
    Case drawn(plane, shifted, with_spike(3));
    EXPECT_EQ(flatten_folds(drawn.set, drawn.moved, {40}).spikes, 0u);
}

// A hexagon whose corners got sharper by a sixth of their height is the drawing's.
TEST(FlattenFolds, a_large_corner_that_was_drawn_stays) {
    const Plane plane = make_plane({0, 0, 0}, {0, 0, 1});
    for (const double stretch : {1.8, 1.95}) {
        Ring drawn, now;
        for (int k = 0; k < 6; ++k) {
            const double turn = 2 * std::numbers::pi * k / 6;
            drawn.push_back({7 * std::cos(turn), 7 * std::sin(turn)});
            now.push_back({stretch * drawn.back().x, drawn.back().y});
        }
        Case one(plane, now, drawn);
        EXPECT_EQ(flatten_folds(one.set, one.moved, {40}).vertices, 0u) << stretch;
    }
}

TEST(FlattenFolds, a_slice_that_keeps_its_spikes_keeps_them) {
    const Plane plane = make_plane({0, 0, 0}, {0, 0, 1});
    for (const bool keeps : {true, false}) {
        Case one(plane, with_spike(3.5), with_spike(0));
        EXPECT_EQ(flatten_folds(one.set, one.moved, {40, {keeps}}).spikes, keeps ? 0u : 1u);
    }
}

// A common point beside the spike was not drawn: how blunt the corner was is told by what was.
TEST(FlattenFolds, a_spike_beside_a_point_that_was_not_drawn_goes) {
    const Plane plane = make_plane({0, 0, 0}, {0, 0, 1});
    Ring now = with_spike(3.5), drawn = with_spike(0);
    Case one(plane, now, drawn);
    one.set.points.insert(one.set.points.begin() + 1, plane.to_space(0.95 * now[0] + 0.05 * now[1]));
    one.set.contours[0].point_count = 41;
    EXPECT_EQ(flatten_folds(one.set, one.moved, {40}).spikes, 2u)
        << "the corner and then the point beside it";
}

// A vertex that was moved past a common point by less than a tenth of a millimetre: the contour would go back
// to it.
TEST(FlattenFolds, a_kink_beside_a_common_point_goes) {
    const Plane plane = make_plane({0, 0, 0}, {0, 0, 1});
    for (const double beyond : {0.03, 0.06}) {
        const Ring ring = with_spike(0);
        Case one(plane, ring, ring);
        for (MovedPoint& point : one.moved) point.drawn += Vec3{1, 0, 0};
        const Vec3 common = plane.to_space(ring[0] + Vec2{0.02, beyond});
        std::vector<Vec3>& all = one.set.points;
        all.insert(std::find(all.begin(), all.end(), plane.to_space(ring[0])), common);
        one.set.contours[0].point_count = 41;
        const Plane across = make_plane(common, {0, 1, 0});
        const Vec2 q = across.to_plane(common);
        crossing_fixtures::add_slice(one.set, across, {q, q + Vec2{5, 5}, q + Vec2{-5, 5}});
        EXPECT_EQ(flatten_folds(one.set, one.moved, {40}).spikes, 1u) << beyond;
        const auto points = one.set.points_of(one.set.contours[0]);
        EXPECT_EQ(std::count(points.begin(), points.end(), common), 1);
        EXPECT_EQ(std::count(points.begin(), points.end(), plane.to_space(ring[0])), 0);
    }
}

// A fold round something that lies in it would cross it.
TEST(FlattenFolds, a_slice_that_would_not_be_sound_keeps_its_contours) {
    const Plane plane = make_plane({0, 0, 0}, {0, 0, 1});
    Case one(plane, notched(0.4, 8), notched(8, 8));
    // An island in the mouth of the notch.
    crossing_fixtures::add_slice(one.set, plane, {{39.5, 19.9}, {40.5, 19.9}, {40.5, 20.1}, {39.5, 20.1}});
    one.set.slices.pop_back();
    one.set.slices[0].contour_count = 2;
    one.set.contours[1].slice = 0;
    const std::vector<Vec3> before = one.set.points;
    EXPECT_EQ(flatten_folds(one.set, one.moved, {40}).folds, 0u);
    EXPECT_EQ(one.set.points, before);
}

}  // namespace
}  // namespace anatomesh::flatten_folds_test
