#include "anatomesh/sample/local_thickness.h"

#include <gtest/gtest.h>

#include <numbers>

#include "anatomesh/sample/analytic_field_for_test.h"
#include "anatomesh/sample/thin_walls.h"

namespace anatomesh::local_thickness_test {
namespace {

using namespace fixtures;

Distance plate(double thickness) {
    return [=](Vec3 p) { return std::abs(p.z) - 0.5 * thickness; };
}

TEST(LocalThickness, measures_a_plate_up_to_its_reach) {
    for (const double thickness : {0.15, 0.3, 0.5, 0.77, 0.99}) {
        const AnalyticField field({plate(thickness)}, 10);
        const LocalThickness local_thickness(field, 1);
        EXPECT_NEAR(local_thickness.thickness(0, {1, 2, 0.5 * thickness}, {0, 0, 1}), thickness, 0.07)
            << thickness;
        EXPECT_NEAR(local_thickness.thickness(0, {1, 2, -0.5 * thickness}, {0, 0, -1}), thickness, 0.07)
            << thickness;
    }
    const AnalyticField thick({plate(1.2)}, 10);
    EXPECT_EQ(LocalThickness(thick, 1).thickness(0, {0, 0, 0.6}, {0, 0, 1}), 1);
}

TEST(LocalThickness, measures_the_gap_between_two_parts) {
    for (const double gap : {0.2, 0.6}) {
        const AnalyticField field({[=](Vec3 p) { return 0.5 * gap - std::abs(p.z); }}, 10);
        EXPECT_NEAR(LocalThickness(field, 1).thickness(0, {0, 0, 0.5 * gap}, {0, 0, -1}), gap, 0.07) << gap;
    }
}

TEST(LocalThickness, a_wall_thinner_than_a_sixteenth_of_the_reach_counts_as_that) {
    const AnalyticField field({plate(0.01)}, 10);
    EXPECT_EQ(LocalThickness(field, 1).thickness(0, {0, 0, 0.005}, {0, 0, 1}), 1.0 / 16);
}

TEST(LocalThickness, finds_the_normal) {
    const AnalyticField field({ball({1, 0, 0}, 5)}, 10);
    const LocalThickness local_thickness(field, 1);
    const auto normal = local_thickness.normal(0, {1, 3, 4});
    ASSERT_TRUE(normal.has_value());
    EXPECT_LT(length(*normal - Vec3{0, 0.6, 0.8}), 1e-3);
    EXPECT_FALSE(local_thickness.normal(0, {100, 0, 0}).has_value());  // clamped: flat
}

TEST(ThinWalls, levels_rise_as_walls_get_thinner) {
    EXPECT_EQ(level_of(0.5, 1), 0);
    EXPECT_EQ(level_of(0.49, 1), 1);
    EXPECT_EQ(level_of(0.29, 1), 2);
    EXPECT_EQ(level_of(0.14, 1), 3);
    EXPECT_EQ(level_of(0.001, 1), max_thin_level);
}

TEST(ThinWalls, sites_of_a_spot_fill_its_neighbourhood_once) {
    const std::vector<ThinSpot> spots{{{5, 5, 5}, 2}, {{5.1, 5, 5}, 2}, {{5, 5, 5}, 1}};
    const std::vector<Vec3> sites = fine_sites({}, spots, 2, 1);
    // Two lattice points a cube of 0.25; a ball of 0.7 and a little.
    EXPECT_NEAR(static_cast<double>(sites.size()), 4 / 3.0 * std::numbers::pi * 0.343 * 1.1 * 128, 25);
    for (std::size_t n = 1; n < sites.size(); ++n) EXPECT_FALSE(sites[n] == sites[n - 1]);
    for (const Vec3& p : sites) EXPECT_LE(length(p - Vec3{5.05, 5, 5}), 0.7 + 0.051);
    EXPECT_GT(fine_sites({}, spots, 1, 1).size(), 0u);
    EXPECT_TRUE(fine_sites({}, spots, 3, 1).empty());
}

}  // namespace
}  // namespace anatomesh::local_thickness_test
