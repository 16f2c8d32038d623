#include "anatomesh/contour/overlay/arrangement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "anatomesh/geom/polygon.h"

namespace anatomesh::arrangement_test {
namespace {

// Two triangles whose bases lie on one line but for the last digit, so that they cross at an angle that rounding makes
// 0. The point where they cross cannot be computed; the bases take each other's ends.
TEST(Arrange, edges_that_run_along_each_other_take_each_others_ends) {
    std::mt19937 random(1);
    const auto number = [&](double low, double high) {
        return low + (high - low) * (random() / 4294967296.0);
    };
    const double infinity = INFINITY;
    int crossed = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        const Vec2 a{number(-50, 50), number(-50, 50)}, b{number(-50, 50), number(-50, 50)};
        Vec2 c = a + number(-0.5, 0.4) * (b - a), d = a + number(0.6, 1.5) * (b - a);
        c.y = std::nextafter(c.y, infinity);
        d.y = std::nextafter(d.y, -infinity);
        if (segment_contact(a, b, c, d) != SegmentContact::cross) continue;
        ++crossed;
        const Vec2 across{a.y - b.y, b.x - a.x};
        std::vector<Ring> rings;
        for (const auto& [p, q, side] : {std::tuple{a, b, 1.0}, std::tuple{c, d, -1.0}}) {
            std::vector<Vec3> points;
            for (const Vec2 v : {p, q, 0.5 * (p + q) + side * across}) points.push_back({v.x, v.y, 0});
            rings.push_back(make_ring(points, {}, 0));
        }
        const auto graph = arrange(rings, {}, most_arrangement_edges);
        ASSERT_TRUE(graph);
        EXPECT_EQ(graph->at.size(), 6u) << "no vertex is made";
        for (const Vec2 p : graph->at) EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y));
    }
    EXPECT_GT(crossed, 300);
}

// A needle one digit wide that crosses itself: no end lies between the ends of the other edge.
TEST(Arrange, a_needle_of_one_digit_comes_to_rest) {
    const double up = std::nextafter(1.0, 2.0);
    for (const double length : {1e-3, 1.0, 100.0}) {
        const std::vector<Vec3> needle{{1, 1, 0}, {1 + length, up, 0}, {1 + length, 1, 0}, {1, up, 0}};
        const std::vector<Ring> rings{make_ring(needle, {}, 0)};
        const auto graph = arrange(rings, {}, most_arrangement_edges);
        ASSERT_TRUE(graph);
        for (const Arrangement::Edge& p : graph->edges) {
            for (const Arrangement::Edge& q : graph->edges) {
                if (&p == &q) continue;
                EXPECT_NE(segment_contact(graph->at[p.a], graph->at[p.b], graph->at[q.a], graph->at[q.b]),
                          SegmentContact::cross);
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::arrangement_test
