#include "anatomesh/contour/clean/close_at_valve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace anatomesh::close_at_valve_test {
namespace {

using Points = std::vector<Vec3>;

// A chamber in the plane y = 0, 40 mm wide at its valve at z = 0 and 50 mm deep.
Points chamber(int points = 41) {
    Points drawn;
    for (int n = 0; n < points; ++n) {
        const double a = std::numbers::pi * (1 + static_cast<double>(n) / (points - 1));
        drawn.push_back({20 * std::cos(a), 0, 50 * std::sin(a)});
    }
    return drawn;
}

Points disc(double radius, double z, double beside = 0) {
    Points ring;
    for (int n = 0; n < 40; ++n) {
        const double a = 2 * std::numbers::pi * n / 40;
        ring.push_back({beside + radius * std::cos(a), radius * std::sin(a), z});
    }
    return ring;
}

TEST(CloseAtValve, a_straight_edge_where_nothing_goes_on_beyond_it) {
    const Points drawn = chamber(), below = disc(15, -20), far = disc(15, 60), beside = disc(10, 5, 80);
    const std::array<std::span<const Vec3>, 3> others{below, far, beside};
    const auto closing = close_at_valve(drawn, others);
    ASSERT_TRUE(closing);
    EXPECT_NEAR(closing->gap_mm, 40, 1e-9);
    EXPECT_EQ(closing->beyond_mm, 0);
    EXPECT_TRUE(closing->between.empty());
}

TEST(CloseAtValve, goes_round_what_is_drawn_beyond_it_whichever_way_it_runs) {
    for (const bool backward : {false, true}) {
        Points drawn = chamber();
        if (backward) std::reverse(drawn.begin(), drawn.end());
        const Points below = disc(15, -20), above = disc(18, 3), higher = disc(12, 6);
        const std::array<std::span<const Vec3>, 3> others{below, above, higher};
        const auto closing = close_at_valve(drawn, others);
        ASSERT_TRUE(closing);
        EXPECT_NEAR(closing->beyond_mm, 6, 1e-9);
        ASSERT_EQ(closing->between.size(), 2u);
        for (const Vec3& p : closing->between) {
            EXPECT_GT(p.z, 6.5);
            EXPECT_LT(p.z, 12);
            EXPECT_NEAR(std::abs(p.x), 20, 1e-9);
        }
        // After the last point comes the one on its side.
        EXPECT_NEAR(closing->between[0].x, drawn.back().x, 1e-9);
    }
}

TEST(CloseAtValve, a_gap_of_more_than_half_of_what_is_drawn_is_no_valve) {
    EXPECT_FALSE(close_at_valve(Points{{0, 0, 0}, {0, 0, -19}, {40, 0, -19}, {40, 0, 0}}, {}));
    EXPECT_TRUE(close_at_valve(Points{{0, 0, 0}, {0, 0, -21}, {40, 0, -21}, {40, 0, 0}}, {}));
    EXPECT_FALSE(close_at_valve(Points{{0, 0, 0}, {0, 0, -21}, {0, 0, 0}}, {}));
}

}  // namespace
}  // namespace anatomesh::close_at_valve_test
