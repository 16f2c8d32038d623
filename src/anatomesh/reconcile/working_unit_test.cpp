// Laws of contours of any size: what is moved is the same share of what is drawn.
#include "anatomesh/reconcile/working_unit.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

#include "anatomesh/reconcile/reconcile.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::working_unit_test {
namespace {

using namespace crossing_fixtures;

ContourSet times(ContourSet set, double factor) {
    for (Vec3& p : set.points) p = factor * p;
    for (Slice& slice : set.slices) slice.plane.origin = factor * slice.plane.origin;
    return set;
}

std::vector<ContourSet> sets_by_several_hands() {
    std::mt19937 random(31);
    std::vector<ContourSet> sets;
    for (int n = 0; n < 4; ++n) {
        sets.push_back(drawn_ball(30, three_stacks(24, 6 + n, 0.05), {1.0, 0.7, 100 + 60 * n}, random));
        sets.push_back(drawn_ball(30, rotational_planes(9 + 2 * n), {1.0, 0.7, 60 + 40 * n}, random));
        sets.push_back(drawn_ball(30, random_planes(12, 15, random), {1.0, 0.7, 100}, random));
    }
    return sets;
}

ReconcileResult reconciled_at(const ContourSet& set, double factor) {
    ReconcileOptions options;
    options.max_disagreement_mm *= factor;
    RunContext context;
    auto result = reconcile_contours(times(set, factor), options, context);
    EXPECT_TRUE(result.ok()) << factor;
    return std::move(result).value();
}

TEST(WorkingUnit, C32_the_unit_follows_the_spacing_within_two_octaves) {
    for (const ContourSet& set : sets_by_several_hands()) {
        const double spacing = drawn_spacing(set);
        for (double factor = 1e-3; factor < 1e3; factor *= 1.3) {
            const double unit = working_unit_mm(times(set, factor)), in_units = factor * spacing / unit;
            EXPECT_GE(in_units, 1.25 * (1 - 1e-9)) << factor;
            EXPECT_LE(in_units, 5 * (1 + 1e-9)) << factor;
            if (factor * spacing >= 1.25 && factor * spacing <= 5) {
                EXPECT_EQ(unit, 1) << factor;
            }
        }
    }
}

TEST(WorkingUnit, C32_sets_a_power_of_two_as_large_give_the_same_bit_for_bit) {
    for (const ContourSet& set : sets_by_several_hands()) {
        // From spacings at which patients' contours are drawn, and from smaller ones.
        const double spacing = drawn_spacing(set), large = 3.5 / spacing, small = 0.9 / spacing;
        for (const auto& [first, factors] : {std::pair{large, std::array{2.0, 16.0, 1024.0}},
                                             std::pair{small, std::array{0.5, 1.0 / 32, 1.0 / 1024}}}) {
            const ContourSet usual_set = times(set, first);
            const ReconcileResult usual = reconciled_at(usual_set, 1);
            EXPECT_GT(usual.stats.max_movement_mm, 0.1 * first);
            for (const double factor : factors) {
                const double bound = 10 * factor;
                ReconcileOptions options;
                options.max_disagreement_mm = bound;
                RunContext context;
                auto other = reconcile_contours(times(usual_set, factor), options, context);
                ASSERT_TRUE(other.ok()) << factor;
                EXPECT_EQ(other.value().kept.points, times(usual.kept, factor).points) << factor;
                EXPECT_EQ(other.value().stats.max_movement_mm, factor * usual.stats.max_movement_mm);
                EXPECT_EQ(other.value().stats.median_mm, factor * usual.stats.median_mm);
                EXPECT_EQ(other.value().stats.shared_points, usual.stats.shared_points);
            }
        }
    }
}

// As nearly as the two octaves of usual spacings have it: movements fade over 10 units.
TEST(WorkingUnit, C32_sets_of_any_size_move_by_about_the_same_share) {
    for (const ContourSet& set : sets_by_several_hands()) {
        const ReconcileResult usual = reconciled_at(set, 1);
        for (const double factor : {25.0, 3.0, 1.0 / 40, 0.007}) {
            const ReconcileResult other = reconciled_at(set, factor);
            EXPECT_EQ(other.stats.difference_after_mm, 0) << factor;
            const double share = other.stats.mean_movement_mm / factor / usual.stats.mean_movement_mm;
            EXPECT_GT(share, 0.4) << factor;
            EXPECT_LT(share, 2.5) << factor;
            EXPECT_NEAR(static_cast<double>(other.kept.points.size()),
                        static_cast<double>(usual.kept.points.size()),
                        0.05 * static_cast<double>(usual.kept.points.size()))
                << factor;
        }
    }
}

// Three slices that agree, but for one small disc that reaches over the line of another slice by next to nothing.
TEST(WorkingUnit, C32_a_specimen_of_any_size_is_moved_by_a_small_share_of_it) {
    ContourSet set;
    const auto circle = [](const Plane& plane, Vec3 center, double radius) {
        const Vec2 middle = plane.to_plane(center);
        Ring ring;
        for (int i = 0; i < 60; ++i) {
            const double angle = 2 * std::numbers::pi * i / 60;
            ring.push_back({middle.x + radius * std::cos(angle), middle.y + radius * std::sin(angle)});
        }
        return ring;
    };
    const Plane x = make_plane({}, {1, 0, 0}), y = make_plane({}, {0, 1, 0}),
                z = make_plane({0, 0, 0.8}, {0, 0, 1});
    add_slice(set, x, circle(x, {}, 1));
    add_slice(set, y, circle(y, {}, 1.002));
    add_slice(set, z, circle(z, {-0.3999, 1.1, 0.8}, 0.4));
    add_slice(set, z, circle(z, {0, 0, 0.8}, 0.601));
    set.contours.back().slice = 2;
    set.slices.pop_back();
    set.slices[2].contour_count = 2;
    for (const double size : {0.2, 0.5, 1.0, 2.0, 5.0, 50.0, 500.0}) {
        const ReconcileResult result = reconciled_at(set, size);
        EXPECT_GT(result.stats.max_movement_mm, 0) << size;
        EXPECT_LT(result.stats.max_movement_mm, 0.03 * size) << size;
    }
}

}  // namespace
}  // namespace anatomesh::working_unit_test
