#include "anatomesh/geom/point_triangle.h"

#include <gtest/gtest.h>

#include <cmath>

namespace anatomesh::point_triangle_test {
namespace {

TEST(PointTriangle, distance_in_every_zone) {
    const Vec3 a{0, 0, 0}, b{4, 0, 0}, c{0, 4, 0};
    EXPECT_DOUBLE_EQ(point_triangle_distance({1, 1, 3}, a, b, c), 3);
    EXPECT_DOUBLE_EQ(point_triangle_distance({-3, -4, 0}, a, b, c), 5);
    EXPECT_DOUBLE_EQ(point_triangle_distance({2, -2, 0}, a, b, c), 2);
    EXPECT_DOUBLE_EQ(point_triangle_distance({4, 4, 0}, a, b, c), std::sqrt(8.0));
    EXPECT_DOUBLE_EQ(point_triangle_distance({7, 0, 4}, a, b, c), 5);
    EXPECT_DOUBLE_EQ(point_triangle_distance({1, 0, 2}, a, b, b), 2);  // degenerate to a segment
    EXPECT_DOUBLE_EQ(point_triangle_distance({0, 3, 4}, a, a, a), 5);  // and to a point
}

}  // namespace
}  // namespace anatomesh::point_triangle_test
