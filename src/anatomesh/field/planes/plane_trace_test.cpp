// Laws of the trace of a field in a plane.
#include "anatomesh/field/planes/plane_trace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "anatomesh/field/slice/distance_map.h"

namespace anatomesh::plane_trace_test {
namespace {

// Its distance is that from the boundary, whatever the values are like, and also where they jump.
TEST(PlaneTrace, rings_and_discs_come_back_with_their_distances) {
    for (const bool jumps : {false, true}) {
        for (const double hole : {-100.0, 3.3}) {
            const auto distance = [&](Vec2 q) {
                const double r = length(q - Vec2{0.3, -0.2});
                return std::max(r - 7.1, hole - r);
            };
            const auto value = [&](Vec2 q) { return jumps ? (distance(q) < 0 ? -1.0 : 40.0) : distance(q); };
            for (const int threads : {1, 3}) {
                const DistanceMap map(trace_in_plane(value, {{-10, -9}, {10, 11}}, 0.25, threads), 4);
                std::mt19937 random(5);
                std::uniform_real_distribution<double> unit(-9, 9);
                for (int n = 0; n < 3000; ++n) {
                    const Vec2 q{unit(random), unit(random)};
                    if (std::abs(distance(q)) < 3) {
                        EXPECT_NEAR(map.value(q), distance(q), 0.01);
                    }
                }
            }
        }
    }
}

// What reaches the rim of the box is closed there; where nothing is inside there is nothing.
TEST(PlaneTrace, is_closed_and_has_the_area) {
    const auto area = [](const std::vector<Edge2>& edges) {
        double twice = 0;
        Vec2 sum;
        for (const Edge2& edge : edges) {
            twice += cross(edge.a, edge.b);
            sum = sum + (edge.b - edge.a);
        }
        EXPECT_NEAR(length(sum), 0, 1e-9);
        return 0.5 * twice;
    };
    const auto wave = [](Vec2 q) { return q.y - std::sin(q.x); };
    EXPECT_NEAR(area(trace_in_plane(wave, {{0, -3}, {2 * std::numbers::pi, 3}}, 0.05, 1)),
                3 * 2 * std::numbers::pi, 0.5);
    EXPECT_TRUE(trace_in_plane([](Vec2) { return 1.0; }, {{0, 0}, {1, 1}}, 0.1, 1).empty());
}

}  // namespace
}  // namespace anatomesh::plane_trace_test
