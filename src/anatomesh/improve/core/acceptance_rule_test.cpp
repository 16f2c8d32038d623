#include "anatomesh/improve/core/acceptance_rule.h"

#include <gtest/gtest.h>

namespace anatomesh::acceptance_rule_test {
namespace {

QualityThreshold threshold_of(double sine, double ratio) {
    return {sine, 1, ratio * ratio};
}

TEST(AcceptanceRule, a_sine_must_rise_by_more_than_a_rounding_error_and_reach_the_least) {
    AcceptanceRule rule;
    for (const double sine : {0.0, 1e-9, 0.1, 0.5, 0.9}) {
        const double needed = rule.needed_sine(threshold_of(sine, 1));
        EXPECT_GT(needed, sine + 1e-4);
        EXPECT_LT(needed, 1.05 * sine + 1e-3);
    }
    rule.least_sine = 0.3;
    EXPECT_EQ(rule.needed_sine(threshold_of(0.1, 1)), 0.3);
    EXPECT_GT(rule.needed_sine(threshold_of(0.3, 1)), 0.3);
}

TEST(AcceptanceRule, where_the_sine_counts_a_ratio_may_stay_or_rise_to_the_bound) {
    AcceptanceRule rule;
    rule.max_radius_edge = 2;
    EXPECT_EQ(rule.allowed_squared_ratio(threshold_of(0.1, 1)), 4);
    EXPECT_EQ(rule.allowed_squared_ratio(threshold_of(0.1, 5)), 25);
    EXPECT_EQ(rule.allowed_squared_ratio(threshold_of(0.1, 1), 3), 9);
}

TEST(AcceptanceRule, where_the_ratio_counts_it_must_fall_and_no_sine_falls_below_the_least) {
    AcceptanceRule rule;
    rule.objective = Objective::radius_edge;
    rule.max_radius_edge = 2;
    rule.least_sine = 0.2;
    EXPECT_LT(rule.allowed_squared_ratio(threshold_of(0.5, 5)), 25);
    EXPECT_GE(rule.allowed_squared_ratio(threshold_of(0.5, 5)), 16);
    EXPECT_EQ(rule.allowed_squared_ratio(threshold_of(0.5, 2.01)), 4);
    EXPECT_EQ(rule.needed_sine(threshold_of(0.5, 5)), 0.2);
    EXPECT_EQ(rule.needed_sine(threshold_of(0.1, 5)), 0.1);
}

TEST(AcceptanceRule, strict_bounds_hold_in_the_place_of_any_cell) {
    AcceptanceRule rule;
    rule.objective = Objective::radius_edge;
    rule.max_radius_edge = 2;
    rule.least_sine = 0.2;
    rule.strict_least_sine = 0.15;
    rule.strict_max_ratio = 3;
    EXPECT_EQ(rule.needed_sine(threshold_of(0.1, 5)), 0.15);
    EXPECT_EQ(rule.allowed_squared_ratio(threshold_of(0.5, 50)), 9);
}

TEST(AcceptanceRule, cells_outside_may_be_as_flat_as_before_but_serve_as_room_only_above_a_bound) {
    const AcceptanceRule rule;
    EXPECT_EQ(rule.needed_outside_sine({1, 0.001, 0}), 0.001);
    EXPECT_LT(rule.needed_outside_sine({1, 0.9, 0}), 0.1);
    EXPECT_GT(rule.needed_outside_sine({1, 0.9, 0}), 0);
}

}  // namespace
}  // namespace anatomesh::acceptance_rule_test
