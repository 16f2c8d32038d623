#include "anatomesh/reconcile/resolve/resolve_conflicting_intervals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/reconcile/reconcile.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"
#include "anatomesh/reconcile/resolve/edit_region.h"

namespace anatomesh::resolve_conflicting_intervals_test {
namespace {

using namespace crossing_fixtures;

constexpr double margin = 8;

// Regions are drawn as (across the common line, along it): the line of all slices' planes with slice 0's is
// the z axis, shifted by where each one crosses that.
struct Drawn {
    Plane plane;
    std::vector<Ring> rings;
};

Vec3 turned(Vec3 p, double turn) {
    const double c = std::cos(turn), s = std::sin(turn);
    const Vec3 q{p.x, c * p.y - s * p.z, s * p.y + c * p.z};
    return {c * q.x - s * q.y, s * q.x + c * q.y, q.z};
}

// A slice through the point `at` whose plane has the z axis and the direction `across`.
void draw(ContourSet& set, double at, Vec3 across, const std::vector<Ring>& rings, double turn) {
    const Vec3 up = turned({0, 0, 1}, turn), out = turned(across, turn), start = turned({at, 0, 0}, turn);
    const Plane plane = make_plane(start, cross(out, up));
    const auto slice = static_cast<std::uint32_t>(set.slices.size());
    if (set.structures.empty()) set.structures.push_back({1, "solid", {200, 200, 200}});
    set.slices.push_back({plane, static_cast<std::uint32_t>(set.contours.size()),
                          static_cast<std::uint32_t>(rings.size()), std::to_string(slice)});
    for (const Ring& ring : rings) {
        Ring in_plane;
        for (const Vec2 q : ring) in_plane.push_back(plane.to_plane(start + q.x * out + q.y * up));
        if (signed_area(in_plane) < 0) std::reverse(in_plane.begin(), in_plane.end());
        set.contours.push_back({0, slice, static_cast<std::uint32_t>(set.points.size()),
                                static_cast<std::uint32_t>(ring.size())});
        for (const Vec2 q : in_plane) set.points.push_back(plane.to_space(q));
    }
}

Ring ellipse(Vec2 middle, double wide, double high, int count = 40) {
    Ring ring;
    for (int k = 0; k < count; ++k) {
        const double at = 2 * std::numbers::pi * (k + 0.3) / count;
        ring.push_back(middle + Vec2{wide * std::cos(at), high * std::sin(at)});
    }
    return ring;
}

// Two bodies with a gap between them on the line.
std::vector<Ring> with_gap(double gap) {
    return {ellipse({0.4, 10 + 0.5 * gap}, 8, 10), ellipse({-0.4, -10 - 0.5 * gap}, 8, 10)};
}

std::vector<LineComparison> compare_all(const ContourSet& set) {
    RunContext context;
    const std::vector<PlanePatch> patches = plane_patches(set);
    return compare_planes(set, patches, crossing_pairs(patches, margin), margin, context);
}

double difference_mm(const ContourSet& set) {
    double sum = 0;
    for (const LineComparison& one : compare_all(set)) sum += one.difference_mm;
    return sum;
}

std::vector<ResolvedInterval> resolve(ContourSet& set, ConflictingIntervalOptions options = {}) {
    RunContext context;
    OriginalPositions drawn = original_positions(set);
    const std::vector<ResolvedInterval> resolved =
        resolve_conflicting_intervals(set, drawn, compare_all(set), compare_all, options, context);
    EXPECT_EQ(drawn.at.size(), set.points.size());
    for (const Slice& slice : set.slices)
        EXPECT_TRUE(slice_faults(plane_rings(set, slice), set.exclusive).empty());
    return resolved;
}

std::vector<Vec3> points_of_slice(const ContourSet& set, std::uint32_t slice) {
    std::vector<Vec3> points;
    for (const Contour& contour : set.contours_of(set.slices[slice]))
        points.insert(points.end(), set.points_of(contour).begin(), set.points_of(contour).end());
    return points;
}

TEST(ResolveConflictingIntervals, slices_that_agree_stay_as_they_are) {
    for (const double turn : {0.0, 0.7}) {
        ContourSet set;
        draw(set, 0, {1, 0, 0}, with_gap(3), turn);
        draw(set, 0, {0, 1, 0}, with_gap(3), turn);
        const ContourSet before = set;
        EXPECT_TRUE(resolve(set).empty());
        EXPECT_EQ(set.points, before.points);
    }
}

TEST(ResolveConflictingIntervals, a_narrow_gap_that_one_slice_has_alone_is_bridged_there) {
    for (const double turn : {0.0, 0.3, 1.1}) {
        for (const double gap : {0.05, 0.5, 2.0, 5.0}) {
            ContourSet set;
            draw(set, 0, {1, 0, 0}, {ellipse({0, 0}, 15, 20 + 0.5 * gap)}, turn);
            draw(set, 0, {0, 1, 0}, with_gap(gap), turn);
            const double before = difference_mm(set);
            ASSERT_GT(before, 0.9 * gap);
            const std::vector<Vec3> other = points_of_slice(set, 0);
            const std::vector<ResolvedInterval> resolved = resolve(set);
            EXPECT_LT(difference_mm(set), 0.01 + 0.1 * gap) << gap;
            EXPECT_EQ(points_of_slice(set, 0), other);
            EXPECT_EQ(set.slices[1].contour_count, 1u);
            ASSERT_FALSE(resolved.empty());
            const ResolvedInterval& bridge = *std::max_element(
                resolved.begin(), resolved.end(), [](const ResolvedInterval& p, const ResolvedInterval& q) {
                    return p.length_mm < q.length_mm;
                });
            EXPECT_EQ(bridge.slice, 1u);
            EXPECT_EQ(bridge.other, 0u);
            EXPECT_TRUE(bridge.inside);
            EXPECT_NEAR(bridge.length_mm, gap, 0.2 + 0.1 * gap);
            EXPECT_LE(bridge.farthest_mm, 0.6 * bridge.length_mm + 0.5);
        }
    }
}

TEST(ResolveConflictingIntervals, what_is_wider_than_contours_may_be_parted_or_joined_over_stays) {
    ContourSet set;
    draw(set, 0, {1, 0, 0}, {ellipse({0, 0}, 15, 23)}, 0.2);
    draw(set, 0, {0, 1, 0}, with_gap(6), 0.2);
    const ContourSet before = set;
    ConflictingIntervalOptions options;
    options.most_parted_mm = 4;
    const std::vector<ResolvedInterval> resolved = resolve(set, options);
    for (const ResolvedInterval& piece : resolved) EXPECT_LT(piece.length_mm, 1);
    EXPECT_EQ(set.slices[1].contour_count, 2u);
    EXPECT_GT(difference_mm(set), 5);
}

TEST(ResolveConflictingIntervals, a_neck_that_the_other_slice_lacks_is_parted) {
    for (const double neck : {0.4, 1.5, 4.0}) {
        ContourSet set;
        draw(set, 0, {1, 0, 0}, {ellipse({0, 0}, 20, 0.5 * neck)}, 0.5);
        draw(set, 0, {0, 1, 0}, {ellipse({14, 0}, 6, 9), ellipse({-14, 0}, 6, 9)}, 0.5);
        ASSERT_NEAR(difference_mm(set), neck, 0.02 * neck);
        const std::vector<ResolvedInterval> resolved = resolve(set);
        ASSERT_EQ(resolved.size(), 1u);
        EXPECT_FALSE(resolved[0].inside);
        EXPECT_EQ(resolved[0].slice, 0u);
        EXPECT_EQ(set.slices[0].contour_count, 2u);
        EXPECT_EQ(difference_mm(set), 0);
    }
}

// The one that is nearer to the line gives way: by as much as it is beyond it, and the clearance.
TEST(ResolveConflictingIntervals, of_two_changes_the_smaller_is_made) {
    for (const double beyond : {0.05, 0.3, 0.8}) {
        ContourSet set;
        draw(set, 0, {1, 0, 0}, {{{-12, -25}, {beyond, -25}, {beyond, 25}, {-12, 25}}}, 0.9);
        std::vector<Ring> two = with_gap(4);
        for (Ring& ring : two) {
            for (Vec2& q : ring) q.y *= 25 / 22.0;
        }
        draw(set, 0, {0, 1, 0}, two, 0.9);
        const std::vector<Vec3> other = points_of_slice(set, 1);
        const std::vector<ResolvedInterval> resolved = resolve(set);
        ASSERT_FALSE(resolved.empty());
        const ResolvedInterval& dent = *std::max_element(
            resolved.begin(), resolved.end(),
            [](const ResolvedInterval& p, const ResolvedInterval& q) { return p.length_mm < q.length_mm; });
        EXPECT_EQ(dent.slice, 0u);
        EXPECT_FALSE(dent.inside);
        EXPECT_LE(dent.farthest_mm, beyond + 0.51);
        EXPECT_EQ(set.slices[1].contour_count, 2u);
        EXPECT_LT(difference_mm(set), 0.3);
    }
}

// A gap that one slice has against three, each of them at a line of its own, changes none of the three.
TEST(ResolveConflictingIntervals, a_slice_that_contradicts_several_is_the_one_that_changes) {
    for (const double parted : {10.0, 1.0}) {
        ContourSet set;
        std::vector<Ring> gap = with_gap(3);
        draw(set, 0, {0, 1, 0}, gap, 0);
        for (const double y : {-1.5, 0.0, 1.5}) {
            // Their contours are 0.2 mm beyond the plane with the gap: they would change by less.
            ContourSet one;
            const Vec3 at{0, y, 0};
            const Plane plane = make_plane(at, {0, 1, 0});
            Ring ring{{-12, -23}, {0.2, -23}, {0.2, 23}, {-12, 23}}, in_plane;
            for (const Vec2 q : ring) in_plane.push_back(plane.to_plane(at + Vec3{q.x, 0, q.y}));
            if (signed_area(in_plane) < 0) std::reverse(in_plane.begin(), in_plane.end());
            add_slice(set, plane, in_plane);
        }
        ASSERT_GT(difference_mm(set), 9);
        std::vector<std::vector<Vec3>> before;
        for (const std::uint32_t s : {1u, 2u, 3u}) before.push_back(points_of_slice(set, s));
        ConflictingIntervalOptions options;
        options.most_parted_mm = parted;
        std::vector<ResolvedInterval> resolved = resolve(set, options);
        std::erase_if(resolved, [](const ResolvedInterval& piece) { return piece.slice == 0; });
        EXPECT_TRUE(resolved.empty());
        for (const std::uint32_t s : {1u, 2u, 3u}) EXPECT_EQ(points_of_slice(set, s), before[s - 1]);
    }
}

TEST(ResolveConflictingIntervals, the_same_at_any_order_of_slices) {
    double farthest = 0;
    for (const bool first : {true, false}) {
        ContourSet set;
        const std::vector<Ring> solid{ellipse({0, 0}, 15, 22)};
        draw(set, 0, {1, 0, 0}, first ? solid : with_gap(2), 0.4);
        draw(set, 0, {0, 1, 0}, first ? with_gap(2) : solid, 0.4);
        double most = 0;
        for (const ResolvedInterval& piece : resolve(set)) most = std::max(most, piece.farthest_mm);
        if (!first) {
            EXPECT_NEAR(most, farthest, 1e-9);
        }
        farthest = most;
    }
}

TEST(ResolveConflictingIntervals, reconciling_settles_what_moving_leaves_and_says_so) {
    for (const double gap : {1.5, 30.0}) {
        ContourSet set;
        draw(set, 0, {1, 0, 0}, {ellipse({0, 0}, 30, 20 + 0.5 * gap)}, 0.4);
        draw(set, 0, {0, 1, 0}, with_gap(gap), 0.4);
        RunContext context;
        const Result<ReconcileResult> result = reconcile_contours(set, {.margin_mm = margin}, context);
        ASSERT_TRUE(result.ok());
        const auto says = [&](const char* code) {
            return std::count_if(context.warnings.begin(), context.warnings.end(),
                                 [&](const Warning& warning) { return warning.code == code; });
        };
        const bool narrow = gap < 2;
        EXPECT_EQ(says("W-RCN-012"), narrow);
        EXPECT_EQ(says("W-RCN-004"), !narrow);
        EXPECT_EQ(result.value().stats.resolved.size(), narrow ? 1u : 0u);
        EXPECT_EQ(result.value().stats.difference_after_mm == 0, narrow);
        EXPECT_EQ(result.value().kept.slices[1].contour_count, narrow ? 1u : 2u);
    }
}

double area_of(const std::vector<EditedRing>& rings, const Plane& plane, std::uint32_t structure) {
    double area = 0;
    for (const EditedRing& ring : rings) {
        if (ring.structure != structure) continue;
        std::vector<Vec2> at;
        for (const Vec3& p : ring.points) at.push_back(plane.to_plane(p));
        area += signed_area(at);
    }
    return area;
}

TEST(Repaint, gives_and_takes_the_region_and_nothing_else) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int n = 0; n < 200; ++n) {
        ContourSet set;
        const Plane plane = make_plane({1, 2, 3}, {unit(random), unit(random), 1.5});
        add_slice(set, plane, ellipse({}, 10, 8));
        std::vector<Vec3> region;
        const Vec2 middle{9 * unit(random), 9 * unit(random)};
        Ring square{{-1.3, -1.1}, {1.2, -1.4}, {1.5, 1.3}, {-1.1, 1.2}};
        for (const Vec2 q : square) region.push_back(plane.to_space(q + middle));
        const std::vector<std::vector<Vec3>> regions{region};
        const auto given = edit_region(set, {0, 0, true, regions, {}}),
                   taken = edit_region(set, {0, 0, false, regions, {}});
        if (!given || !taken) continue;  // they touch in a vertex
        const double before = signed_area(ellipse({}, 10, 8)), size = signed_area(square);
        const double with = area_of(*given, plane, 0), without = area_of(*taken, plane, 0);
        EXPECT_NEAR(with - without, size, 1e-9);
        EXPECT_GE(with, before - 1e-9);
        EXPECT_LE(without, before + 1e-9);
        // Twice is once.
        const ContourSet again = with_edited(set, 0, *given);
        const auto twice = edit_region(again, {0, 0, true, regions, {}});
        ASSERT_TRUE(twice.has_value());
        EXPECT_NEAR(area_of(*twice, plane, 0), with, 1e-9);
        EXPECT_EQ(farthest_change(again, 0, *twice), 0);
    }
}

TEST(Repaint, structures_that_exclude_each_other_share_the_new_wall) {
    ContourSet set;
    const Plane plane = make_plane({}, {0, 0, 1});
    add_slice(set, plane, {{-10, -10}, {0, -10}, {0, 10}, {-10, 10}});
    set.exclusive = true;
    set.structures.push_back({2, "other", {1, 2, 3}});
    set.slices[0].contour_count = 2;
    set.contours.push_back({1, 0, 4, 4});
    for (const Vec2 q : Ring{{0, -10}, {10, -10}, {10, 10}, {0, 10}}) set.points.push_back(plane.to_space(q));
    const std::vector<std::vector<Vec3>> regions{{{-1, -2, 0}, {3, -2, 0}, {3, 2, 0}, {-1, 2, 0}}};
    const auto rings = edit_region(set, {0, 0, true, regions, {}});
    ASSERT_TRUE(rings.has_value());
    EXPECT_NEAR(area_of(*rings, plane, 0), 200 + 12, 1e-9);
    EXPECT_NEAR(area_of(*rings, plane, 1), 200 - 12, 1e-9);
    EXPECT_NEAR(farthest_change(set, 0, *rings), 3, 1e-9);
    const auto taken = edit_region(set, {0, 0, false, regions, {}});
    ASSERT_TRUE(taken.has_value());
    EXPECT_NEAR(area_of(*taken, plane, 0), 200 - 4, 1e-9);
    EXPECT_NEAR(area_of(*taken, plane, 1), 200 - 12, 1e-9);
}

}  // namespace
}  // namespace anatomesh::resolve_conflicting_intervals_test
