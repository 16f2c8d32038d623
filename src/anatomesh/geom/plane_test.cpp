#include "anatomesh/geom/plane.h"

#include <gtest/gtest.h>

#include <random>

namespace anatomesh::plane_test {
namespace {

void expect_right_handed_frame(const Plane& plane) {
    for (const Vec3 axis : {plane.u, plane.v, plane.normal}) EXPECT_NEAR(length(axis), 1, 1e-15);
    EXPECT_NEAR(dot(plane.u, plane.v), 0, 1e-15);
    EXPECT_NEAR(dot(plane.u, plane.normal), 0, 1e-15);
    EXPECT_LT(length(cross(plane.u, plane.v) - plane.normal), 1e-15);
}

TEST(Plane, frames_are_orthonormal_and_right_handed_for_any_normal) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    for (int n = 0; n < 10000; ++n) {
        const Vec3 direction =
            std::exp(20 * normal(random)) * Vec3{normal(random), normal(random), normal(random)};
        const Plane plane = make_plane({normal(random), normal(random), normal(random)}, direction);
        expect_right_handed_frame(plane);
        EXPECT_LT(length(plane.normal - normalized(direction)), 1e-15);
    }
}

TEST(Plane, frames_of_the_axes) {
    for (const double scale : {1.0, 0.25, 1e6}) {
        const Plane axial = make_plane({1, 2, 3}, {0, 0, scale});
        EXPECT_EQ(axial.u, (Vec3{1, 0, 0}));
        EXPECT_EQ(axial.v, (Vec3{0, 1, 0}));
        EXPECT_EQ(axial.normal, (Vec3{0, 0, 1}));
    }
    for (const Vec3 normal : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, -1}, Vec3{1, 1, 1}, Vec3{-1, -1, 1}}) {
        expect_right_handed_frame(make_plane({}, normal));
    }
}

TEST(Plane, to_plane_and_to_space_are_inverse) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> coordinate(-100, 100);
    for (int n = 0; n < 1000; ++n) {
        const Vec3 normal{coordinate(random), coordinate(random), coordinate(random)};
        const Plane plane = make_plane({coordinate(random), coordinate(random), coordinate(random)}, normal);
        const Vec2 q{coordinate(random), coordinate(random)};
        EXPECT_LT(length(plane.to_plane(plane.to_space(q)) - q), 1e-12);
        EXPECT_NEAR(plane.signed_distance(plane.to_space(q)), 0, 1e-12);
        EXPECT_NEAR(plane.signed_distance(plane.to_space(q) + 3.0 * plane.normal), 3, 1e-12);
    }
}

}  // namespace
}  // namespace anatomesh::plane_test
