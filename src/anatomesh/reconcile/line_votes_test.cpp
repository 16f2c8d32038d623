#include "anatomesh/reconcile/line_votes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "anatomesh/reconcile/reconcile.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh {
namespace {

using namespace crossing_fixtures;

constexpr double radius = 20;
constexpr double margin = 5;

// Planes about the z axis through a ball; on the first `beside` of them the region is what lies at least 2 mm
// beside the axis, on the one side.
ContourSet ball_about_axis(int planes, int beside, double off_axis_mm = 0) {
    ContourSet set;
    for (int n = 0; n < planes; ++n) {
        const double angle = std::numbers::pi * n / planes;
        const Plane plane = make_plane(off_axis_mm * Vec3{std::cos(9.0 * n), std::sin(9.0 * n), 0},
                                       {-std::sin(angle), std::cos(angle), 0});
        Ring ring;
        for (int k = 0; k < 96; ++k) {
            const double at = 2 * std::numbers::pi * k / 96 + 0.01;
            ring.push_back(radius * Vec2{std::cos(at), std::sin(at)});
        }
        if (n < beside) {
            for (Vec2& q : ring) {
                Vec3 p = plane.to_space(q);
                const Vec3 across{std::cos(angle), std::sin(angle), 0};
                const double x = dot(p, across);
                q = plane.to_plane(p + (2 + (x + radius) / (2 * radius) * (radius - 2) - x) * across);
            }
        }
        add_slice(set, plane, ring);
    }
    return set;
}

std::vector<LineComparison> compare(const ContourSet& set) {
    RunContext context;
    const std::vector<PlanePatch> patches = plane_patches(set);
    return compare_planes(set, patches, crossing_pairs(patches, margin), margin, context);
}

TEST(LineVotes, count_the_slices_that_say_the_same_at_a_place) {
    for (const int beside : {1, 3, 4, 5, 7}) {
        const std::vector<LineComparison> comparisons = compare(ball_about_axis(8, beside));
        const LineVotes votes(comparisons);
        for (const LineComparison& one : comparisons) {
            for (const std::uint32_t own : {one.a, one.b}) {
                // Of those beside no two have a comparison: they have no ends on the axis.
                if (static_cast<int>(own) < beside) continue;
                const double t = one.line.along({0, 0, 3});
                EXPECT_EQ(votes.most_agree(one, own, t), beside < 4) << beside << ": " << own;
                EXPECT_TRUE(votes.most_agree(one, own, one.line.along({0, 0, radius + 1})));
            }
        }
    }
}

TEST(LineVotes, two_slices_have_no_majority) {
    const std::vector<LineComparison> comparisons = compare(ball_about_axis(2, 1));
    ASSERT_EQ(comparisons.size(), 1u);
    const LineVotes votes(comparisons);
    EXPECT_FALSE(votes.most_agree(comparisons[0], 0, 0));
    EXPECT_FALSE(votes.most_agree(comparisons[0], 1, 0));
}

// How far the contours of the slices from `first` on moved at most.
double most_moved(const ContourSet& set, std::size_t first, RunContext& context) {
    ReconcileOptions options;
    options.margin_mm = margin;
    options.max_disagreement_mm = 100;
    const Result<ReconcileResult> result = reconcile_contours(set, options, context);
    EXPECT_TRUE(result.ok());
    double most = 0;
    for (std::size_t s = first; s < set.slices.size(); ++s)
        most = std::max(most, result.value().stats.movements[s].max_mm);
    return most;
}

// One slice of twelve that does not reach the axis: the others are not cut off there for its sake; it is
// taken over it, and named.
TEST(LineVotes, the_many_do_not_give_way_to_the_one) {
    RunContext context;
    EXPECT_LT(most_moved(ball_about_axis(12, 1), 1, context), 0.5);
    const auto says = [&](const char* code) {
        return std::any_of(context.warnings.begin(), context.warnings.end(),
                           [&](const Warning& warning) { return warning.code == code; });
    };
    EXPECT_TRUE(says("W-RCN-003"));
    EXPECT_TRUE(says("W-RCN-010"));
    EXPECT_FALSE(says("W-RCN-004"));
    // Planes as rounded in a file.
    EXPECT_LT(most_moved(ball_about_axis(12, 1, 1e-4), 1, context), 0.5);
    // All agree: nothing moves.
    RunContext sound;
    EXPECT_EQ(most_moved(ball_about_axis(12, 0), 0, sound), 0);
}

// Up to five of twelve slices that do not reach the axis come to reach it, and all agree; they move by what
// they lie beside it, and by what a contour is led beyond a line, not more. None is taken farther than the
// bound.
TEST(LineVotes, the_few_are_taken_over_to_where_the_many_are) {
    for (const int beside : {1, 2, 5}) {
        for (const double bound : {20.0, 1.0}) {
            ReconcileOptions options;
            options.margin_mm = margin;
            options.max_disagreement_mm = bound;
            RunContext context;
            const Result<ReconcileResult> result =
                reconcile_contours(ball_about_axis(12, beside), options, context);
            SCOPED_TRACE(testing::Message() << beside << " beside, bound " << bound);
            if (!result.ok()) {
                EXPECT_EQ(result.error().code, "E-RCN-001");
                EXPECT_LT(bound, 2);
                continue;
            }
            const ReconcileStats& stats = result.value().stats;
            EXPECT_LE(stats.max_movement_mm, bound);
            if (bound < 2) {
                EXPECT_EQ(stats.taken_over.count, 0u);
                continue;
            }
            EXPECT_EQ(stats.taken_over.count, static_cast<std::uint64_t>(beside));
            EXPECT_LT(stats.taken_over.slice, static_cast<std::uint32_t>(beside));
            EXPECT_GE(stats.taken_over.farthest_mm, 2);
            EXPECT_GT(stats.difference_mm, 20.0 * beside);
            EXPECT_LT(stats.difference_after_mm, 0.01 * stats.difference_mm);
        }
    }
}

}  // namespace
}  // namespace anatomesh
