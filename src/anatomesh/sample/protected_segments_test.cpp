#include "anatomesh/sample/protected_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace anatomesh::protected_segments_test {
namespace {

double distance_to_segment(Vec3 p, Vec3 a, Vec3 b) {
    const double t = std::clamp(dot(p - a, b - a) / squared_length(b - a), 0.0, 1.0);
    return length(p - (a + t * (b - a)));
}

struct RandomPlaces {
    std::mt19937_64 random{7};
    double number(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    }
    Vec3 point(double reach) { return {number(-reach, reach), number(-reach, reach), number(-reach, reach)}; }
};

TEST(ProtectedSegments,
     guards_the_share_of_the_ball_and_what_is_near_to_the_segment_and_nothing_outside_the_ball) {
    RandomPlaces places;
    int let_through = 0;
    for (int n = 0; n < 200; ++n) {
        const Vec3 a = places.point(3), b = places.point(3), middle = 0.5 * (a + b);
        const double half = 0.5 * length(b - a);
        ProtectedSegments protected_segments(1, 1, 0.8), balls_alone(1, 1);
        protected_segments.add_segment(a, b);
        balls_alone.add_segment(a, b);
        for (int k = 0; k < 200; ++k) {
            const Vec3 p = k % 2 ? middle + places.number(-1, 1) * (b - middle) + places.point(0.1 * half)
                                 : middle + places.point(1.2 * half);
            const double from_middle = length(p - middle);
            EXPECT_EQ(protected_segments.ball_at(p, 1) == 0, from_middle < half);
            EXPECT_EQ(protected_segments.ball_at(p, 0), ProtectedSegments::no_ball);
            EXPECT_EQ(balls_alone.ball_at(p, 0.5) == 0, from_middle < 0.5 * half);
            const bool guarded = protected_segments.ball_at(p, 0.5) == 0;
            if (from_middle < 0.5 * half) {
                EXPECT_TRUE(guarded);
            } else if (from_middle > half) {
                EXPECT_FALSE(guarded);
            }
            if (guarded || from_middle > 0.97 * half) continue;
            // A point let through inside the ball is no nearer to the segment than a share of its way to the
            // ball's rim.
            EXPECT_GT(distance_to_segment(p, a, b), 0.2 * (half - from_middle));
            ++let_through;
        }
    }
    EXPECT_GT(let_through, 1000);
}

// Lengths from a hundredth to ten thousand sizes in one set: the ball is that which a search of all finds.
TEST(ProtectedSegments, finds_the_ball_of_any_length_among_short_and_long_ones) {
    RandomPlaces places;
    int found = 0;
    for (int set = 0; set < 40; ++set) {
        ProtectedSegments protected_segments(1, 50);
        std::vector<std::pair<Vec3, double>> balls;  // middle, radius
        for (int n = 0; n < 50; ++n) {
            const double half = std::pow(10, places.number(-2, 4));
            const Vec3 middle = places.point(100), direction = places.point(1);
            const Vec3 along = (half / length(direction)) * direction;
            const std::uint32_t ball = protected_segments.add_segment(middle - along, middle + along);
            balls.emplace_back(0.5 * ((middle - along) + (middle + along)),
                               protected_segments.ball_radius(ball));
        }
        for (int k = 0; k < 200; ++k) {
            const Vec3 p = k % 4 ? places.point(200) : balls[k % 50].first;
            std::uint32_t expected = ProtectedSegments::no_ball;
            for (std::uint32_t n = 0; n < balls.size(); ++n) {
                if (length(p - balls[n].first) < balls[n].second &&
                    (expected == ProtectedSegments::no_ball || balls[n].second > balls[expected].second))
                    expected = n;
            }
            EXPECT_EQ(protected_segments.ball_at(p), expected) << set << ' ' << k;
            found += expected != ProtectedSegments::no_ball;
        }
    }
    EXPECT_GT(found, 1000);
}

TEST(ProtectedSegments, names_the_longest_of_several_segments_until_it_is_dropped) {
    ProtectedSegments protected_segments(1, 3, 0.8);
    const std::uint32_t short_one = protected_segments.add_segment({-1, 0, 0}, {1, 0, 0});
    const std::uint32_t long_one = protected_segments.add_segment({-2, 0.1, 0}, {2, 0.1, 0});
    EXPECT_EQ(protected_segments.ball_at({0.8, 0.05, 0}, 0.5), long_one);
    EXPECT_EQ(protected_segments.ball_at({0, 0.05, 0}, 0.5), long_one);
    protected_segments.drop_ball(long_one);
    EXPECT_EQ(protected_segments.ball_at({0, 0.05, 0}, 0.5), short_one);
    // Beyond half the ball, beside the segment.
    EXPECT_EQ(protected_segments.ball_at({0.8, 0.03, 0}, 0.5), short_one);
    protected_segments.drop_ball(short_one);
    EXPECT_EQ(protected_segments.ball_at({0, 0.05, 0}, 0.5), ProtectedSegments::no_ball);
}

}  // namespace
}  // namespace anatomesh::protected_segments_test
