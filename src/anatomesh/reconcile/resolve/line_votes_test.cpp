#include "anatomesh/reconcile/resolve/line_votes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "anatomesh/reconcile/move/shared_points.h"
#include "anatomesh/reconcile/reconcile.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::line_votes_test {
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
                EXPECT_EQ(votes.most_differ(one, own, t), beside > 4) << beside << ": " << own;
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
    EXPECT_FALSE(votes.most_differ(comparisons[0], 0, 0));
    EXPECT_FALSE(votes.most_differ(comparisons[0], 1, 0));
}

// A box in a plane about the z axis: from `near` to `far` beside the axis, low to high along it, with a
// vertex every `step` mm.
Ring box_in(const Plane& plane, double angle, double near, double far, double low, double high, double step) {
    const Vec3 across{std::cos(angle), std::sin(angle), 0}, up{0, 0, 1};
    const std::vector<Vec2> corners{{near, low}, {far, low}, {far, high}, {near, high}};
    Ring ring;
    for (std::size_t c = 0; c < 4; ++c) {
        const Vec2 a = corners[c], way = corners[(c + 1) % 4] - a;
        const int count = std::max(1, static_cast<int>(std::round(length(way) / step)));
        for (int k = 0; k < count; ++k) {
            const Vec2 p = a + (static_cast<double>(k) / count) * way;
            ring.push_back(plane.to_plane(p.x * across + p.y * up));
        }
    }
    double area = 0;
    for (std::size_t k = 0; k < ring.size(); ++k) area += cross(ring[k], ring[(k + 1) % ring.size()]);
    if (area < 0) std::reverse(ring.begin(), ring.end());
    return ring;
}

// Three planes about the axis: boxes over it, and one that lies beside it or elsewhere along it.
ContourSet boxes_about_axis(double near, double low, double high, double step) {
    ContourSet set;
    for (int n = 0; n < 3; ++n) {
        const double angle = std::numbers::pi * n / 3;
        const Plane plane = make_plane({}, {-std::sin(angle), std::cos(angle), 0});
        const bool is_other = n == 2;
        add_slice(set, plane,
                  box_in(plane, angle, is_other ? near : -20, 20, is_other ? low : -30, is_other ? high : 30,
                         step));
    }
    return set;
}

// It neither bears out an interval nor a gap.
TEST(LineVotes, a_slice_that_is_drawn_elsewhere_has_none) {
    const ContourSet set = boxes_about_axis(-20, -160, -120, 2);
    ContourSet gap = set;
    // The second slice's box ends beside the axis: where the first goes on it has none.
    const Plane& plane = gap.slices[1].plane;
    const Vec3 across = cross(plane.normal, Vec3{0, 0, 1});
    for (std::uint32_t k = 0; k < gap.contours[1].point_count; ++k) {
        Vec3& p = gap.points[gap.contours[1].first_point + k];
        const double x = dot(p, across);
        p += (3 + 0.4 * (x + 20) - x) * across;
    }
    const std::vector<LineComparison> comparisons = compare(gap);
    const LineVotes votes(comparisons);
    const auto one = std::find_if(comparisons.begin(), comparisons.end(),
                                  [](const LineComparison& c) { return c.a == 0 && c.b == 1; });
    ASSERT_NE(one, comparisons.end());
    const double middle = one->line.along({0, 0, 0});
    EXPECT_FALSE(votes.most_agree(*one, 0, middle));  // one against one
    EXPECT_FALSE(votes.most_agree(*one, 1, middle));
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
                EXPECT_TRUE(stats.taken_over.empty());
                continue;
            }
            ASSERT_EQ(stats.taken_over.size(), static_cast<std::size_t>(beside));
            for (std::uint32_t s = 0; s < stats.taken_over.size(); ++s) {
                EXPECT_EQ(stats.taken_over[s].slice, s);
                EXPECT_GE(stats.taken_over[s].farthest_mm, 2);
                EXPECT_LE(stats.movements[s].max_mm, 1.2 * stats.taken_over[s].farthest_mm);
            }
            for (std::size_t s = static_cast<std::size_t>(beside); s < stats.movements.size(); ++s)
                EXPECT_LT(stats.movements[s].max_mm, 0.5);
            EXPECT_GT(stats.difference_mm, 20.0 * beside);
            EXPECT_LT(stats.difference_after_mm, 0.01 * stats.difference_mm);
        }
    }
}

// Wherever vertices lie along the side that faces the axis, at the interval's ends and middle too.
TEST(LineVotes, a_box_beside_the_axis_is_taken_over_it_wherever_its_vertices_are) {
    for (const double step : {2.0, 3.0, 7.0, 60.0}) {
        ReconcileOptions options;
        options.margin_mm = margin;
        RunContext context;
        const Result<ReconcileResult> result =
            reconcile_contours(boxes_about_axis(4, -30, 30, step), options, context);
        ASSERT_TRUE(result.ok());
        const ReconcileStats& stats = result.value().stats;
        SCOPED_TRACE(testing::Message() << "a vertex every " << step << " mm");
        ASSERT_EQ(stats.taken_over.size(), 1u);
        EXPECT_EQ(stats.taken_over[0].slice, 2u);
        EXPECT_NEAR(stats.taken_over[0].farthest_mm, 4, 1e-6);
        EXPECT_GT(stats.difference_mm, 100);
        EXPECT_LT(stats.difference_after_mm, 0.01 * stats.difference_mm);
        EXPECT_LE(stats.max_movement_mm, options.max_disagreement_mm);
        // Not where it lies further away than contours may move.
        options.max_disagreement_mm = 4;
        const Result<ReconcileResult> bound =
            reconcile_contours(boxes_about_axis(4, -30, 30, step), options, context);
        EXPECT_TRUE(!bound.ok() || bound.value().stats.taken_over.empty());
    }
}

// Eleven slices agree at the poles, one ends elsewhere: the eleven have one point there, bit for bit.
TEST(SharedPoints, are_those_of_most_slices_where_few_end_elsewhere) {
    for (const double scale : {1.03, 0.97}) {
        ContourSet set = ball_about_axis(12, 0);
        for (std::uint32_t k = 0; k < set.contours[4].point_count; ++k)
            set.points[set.contours[4].first_point + k] = scale * set.points[set.contours[4].first_point + k];
        const std::vector<LineComparison> comparisons = compare(set);
        insert_shared_points(set, comparisons, std::vector<bool>(set.points.size(), false));
        int shared = 0;
        for (const double z : {-radius, radius}) {
            std::vector<Vec3> on_axis;
            for (const Contour& contour : set.contours) {
                for (const Vec3& p : set.points_of(contour)) {
                    if (std::hypot(p.x, p.y) > 1e-9 || p.z * z < 0) continue;
                    on_axis.push_back(p);
                    EXPECT_NE(contour.slice, 4u);
                }
            }
            EXPECT_EQ(on_axis.size(), 11u);
            for (const Vec3& p : on_axis) {
                EXPECT_EQ(p, on_axis.front());
                ++shared;
            }
            ASSERT_FALSE(on_axis.empty());
            EXPECT_NEAR(std::abs(on_axis.front().z), radius, 0.05);  // the ball's chords
        }
        EXPECT_EQ(shared, 22);
    }
}

}  // namespace
}  // namespace anatomesh::line_votes_test
