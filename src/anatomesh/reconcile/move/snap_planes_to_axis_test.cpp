#include "anatomesh/reconcile/move/snap_planes_to_axis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::snap_planes_to_axis_test {
namespace {

using namespace crossing_fixtures;

// Circles of planes about an axis beside the middle, whose planes and points are as far off as `noise_mm`.
ContourSet about_axis(int count, double noise_mm) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> off(-noise_mm, noise_mm);
    ContourSet set;
    for (int k = 0; k < count; ++k) {
        const double angle = std::numbers::pi * k / count;
        const Plane exact = make_plane({4, 3, 0}, {std::cos(angle), std::sin(angle), 0});
        const Plane drawn = make_plane(exact.origin + off(random) * exact.normal,
                                       exact.normal + 0.025 * Vec3{off(random), off(random), off(random)});
        Ring ring;
        for (int n = 0; n < 40; ++n) {
            const double a = 2 * std::numbers::pi * n / 40;
            ring.push_back({20 * std::cos(a), 20 * std::sin(a)});
        }
        add_slice(set, drawn, ring);
        for (std::size_t p = set.points.size() - ring.size(); p < set.points.size(); ++p)
            set.points[p] += off(random) * drawn.normal;
    }
    return set;
}

TEST(SnapPlanesToAxis, planes_about_an_axis_run_through_one_line_and_hold_their_points) {
    ContourSet set = about_axis(24, 0.008);
    const ContourSet before = set;
    const PlaneSnappingStats stats = snap_planes_to_axis(set);
    EXPECT_GE(stats.about_axis, 20u);
    EXPECT_GT(stats.points, 900u);
    EXPECT_LT(stats.farthest_mm, 0.05);
    // Two lines of four planes are one.
    const Vec3 one = normalized(cross(set.slices[0].plane.normal, set.slices[11].plane.normal)),
               other = normalized(cross(set.slices[5].plane.normal, set.slices[17].plane.normal));
    EXPECT_LT(length(cross(one, other)), 1e-12);
    const Plane &p = set.slices[0].plane, &q = set.slices[11].plane;
    const Vec3 across = cross(cross(p.normal, q.normal), p.normal);
    const Vec3 at = p.origin - (q.signed_distance(p.origin) / dot(across, q.normal)) * across;
    for (const Slice& slice : set.slices) {
        EXPECT_LT(std::abs(slice.plane.signed_distance(at)), 1e-9);
        EXPECT_LT(std::abs(dot(slice.plane.normal, one)), 1e-12);
        for (const Contour& contour : set.contours_of(slice)) {
            for (const Vec3& x : set.points_of(contour))
                EXPECT_LT(std::abs(slice.plane.signed_distance(x)), 1e-7);
        }
    }
    for (std::size_t k = 0; k < set.points.size(); ++k)
        EXPECT_LT(length(set.points[k] - before.points[k]), 0.05);
}

TEST(SnapPlanesToAxis, what_is_exact_stays_to_the_last_bit) {
    ContourSet set = about_axis(24, 0);
    const ContourSet before = set;
    const PlaneSnappingStats stats = snap_planes_to_axis(set);
    EXPECT_EQ(stats.about_axis, 0u);
    EXPECT_EQ(stats.points, 0u);
    EXPECT_EQ(set.points, before.points);
}

// Planes that miss a line by more than rounding are no scan about it, nor are a few.
TEST(SnapPlanesToAxis, planes_that_were_not_meant_to_meet_in_a_line_stay) {
    for (const auto& [count, noise] : {std::pair{24, 1.0}, std::pair{4, 0.008}}) {
        ContourSet set = about_axis(count, noise);
        const ContourSet before = set;
        EXPECT_EQ(snap_planes_to_axis(set).about_axis, 0u);
        for (std::size_t s = 0; s < set.slices.size(); ++s) {
            EXPECT_EQ(set.slices[s].plane.origin, before.slices[s].plane.origin);
            EXPECT_EQ(set.slices[s].plane.normal, before.slices[s].plane.normal);
        }
    }
}

// A fan that is a part of all slices, rounded as a file of four decimals rounds.
TEST(SnapPlanesToAxis, fewer_planes_than_most_run_through_one_line_too_if_they_pass_it_nearly) {
    for (const int count : {3, 4, 5, 7}) {
        ContourSet set = about_axis(count, 0.0003);
        for (int k = 0; k < 9; ++k) {
            Ring ring;
            for (int n = 0; n < 40; ++n) {
                const double a = 2 * std::numbers::pi * n / 40;
                ring.push_back({15 * std::cos(a), 15 * std::sin(a)});
            }
            add_slice(set, make_plane({0, 0, 3.0 * k - 12}, {0.1, 0.05, 1}), ring);
        }
        const ContourSet before = set;
        EXPECT_EQ(snap_planes_to_axis(set).about_axis, static_cast<std::uint32_t>(count));
        const Vec3 one = normalized(cross(set.slices[0].plane.normal, set.slices[1].plane.normal));
        for (int k = 0; k < count; ++k)
            EXPECT_LT(std::abs(dot(set.slices[static_cast<std::size_t>(k)].plane.normal, one)), 1e-12);
        for (std::size_t s = static_cast<std::size_t>(count); s < set.slices.size(); ++s)
            EXPECT_EQ(set.slices[s].plane.normal, before.slices[s].plane.normal);
    }
}

}  // namespace
}  // namespace anatomesh::snap_planes_to_axis_test
