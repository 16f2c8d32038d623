#include "anatomesh/reconcile/regularize/enforce_clearance.h"

#include <gtest/gtest.h>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::enforce_clearance_test {
namespace {

using namespace crossing_fixtures;

constexpr double least_mm = 0.2;

// A region with a notch whose tip comes within `gap` of the far side.
Ring notched(double gap) {
    return {{-10, -10}, {10, -10}, {10, 10}, {2, 10}, {0, -10 + gap}, {-2, 10}, {-10, 10}};
}

ContourSet one_slice(const Ring& ring, const Plane& plane) {
    ContourSet set;
    add_slice(set, plane, ring);
    return set;
}

double tip_gap(const ContourSet& set) {
    double least = 1e9;
    const Plane& plane = set.slices[0].plane;
    for (const Vec3& p : set.points_of(set.contours[0])) {
        const Vec2 q = plane.to_plane(p);
        if (std::abs(q.x) < 1 && q.y > -10 + 1e-12) least = std::min(least, q.y + 10);
    }
    return least;
}

TEST(EnforceClearance, what_movement_brought_to_all_but_touch_comes_apart) {
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{1, 2, 3}}) {
        const Plane plane = make_plane({1, 2, 3}, normal);
        for (const double gap : {1e-6, 1e-3, 0.05, 0.09}) {
            ContourSet set = one_slice(notched(gap), plane);
            OriginalPositions drawn = original_positions(one_slice(notched(3), plane));
            const ClearanceStats kept = enforce_clearance(set, drawn, least_mm);
            EXPECT_EQ(kept.places, 1u) << gap;
            EXPECT_NEAR(kept.farthest_mm, least_mm - gap, 1e-9);
            EXPECT_NEAR(tip_gap(set), least_mm, 1e-9);
            EXPECT_TRUE(slice_faults(plane_rings(set, set.slices[0]), false).empty());
            EXPECT_EQ(drawn.at, one_slice(notched(3), plane).points);
        }
    }
}

TEST(EnforceClearance, what_was_drawn_as_near_or_is_far_enough_keeps_its_bits) {
    const Plane plane = make_plane({}, {0, 0, 1});
    for (const auto& [gap, was] : {std::pair{0.05, 0.06}, std::pair{0.001, 0.001}, std::pair{0.11, 3.0}}) {
        ContourSet set = one_slice(notched(gap), plane);
        const ContourSet before = set;
        OriginalPositions drawn = original_positions(one_slice(notched(was), plane));
        EXPECT_EQ(enforce_clearance(set, drawn, least_mm).places, 0u);
        EXPECT_EQ(set.points, before.points);
    }
}

TEST(EnforceClearance, a_vertex_in_another_slices_plane_stays_and_the_segment_gives_way) {
    ContourSet set = one_slice(notched(0.01), make_plane({}, {0, 0, 1}));
    add_slice(set, make_plane({}, {1, 0, 0}), {{-20, -20}, {20, -20}, {20, 20}, {-20, 20}});
    ContourSet was = one_slice(notched(3), make_plane({}, {0, 0, 1}));
    add_slice(was, make_plane({}, {1, 0, 0}), {{-20, -20}, {20, -20}, {20, 20}, {-20, 20}});
    OriginalPositions drawn = original_positions(was);
    EXPECT_EQ(enforce_clearance(set, drawn, least_mm).places, 1u);
    EXPECT_EQ(set.contours[0].point_count, 8u);
    EXPECT_EQ(drawn.at.size(), set.points.size());
    EXPECT_NEAR(tip_gap(set), 0.01, 1e-12);
    double lowest = 0;
    for (const Vec3& p : set.points_of(set.contours[0])) lowest = std::min(lowest, p.y);
    EXPECT_NEAR(lowest, -10 - (least_mm - 0.01), 1e-9);
}

TEST(EnforceClearance, what_structures_share_stays_shared) {
    const Plane plane = make_plane({}, {0, 0, 1});
    const auto two = [&](double gap) {
        ContourSet set =
            one_slice({{-10, -10}, {10, -10}, {10, 10}, {2, 10}, {0, -10 + gap}, {-2, 10}, {-10, 10}}, plane);
        set.structures.push_back({2, "wedge", {1, 2, 3}});
        set.exclusive = true;
        set.slices[0].contour_count = 2;
        set.contours.push_back({1, 0, static_cast<std::uint32_t>(set.points.size()), 3});
        for (const Vec2 q : Ring{{-2, 10}, {0, -10 + gap}, {2, 10}}) set.points.push_back(plane.to_space(q));
        return set;
    };
    ContourSet set = two(0.01);
    OriginalPositions drawn = original_positions(two(3));
    EXPECT_GE(enforce_clearance(set, drawn, least_mm).places, 1u);
    EXPECT_NEAR(tip_gap(set), least_mm, 1e-9);
    const auto first = set.points_of(set.contours[0]);
    for (const Vec3& p : set.points_of(set.contours[1]))
        EXPECT_NE(std::find(first.begin(), first.end(), p), first.end());
}

}  // namespace
}  // namespace anatomesh::enforce_clearance_test
