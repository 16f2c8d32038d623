#include "anatomesh/geom/plane_sides.h"

#include <gtest/gtest.h>

#include <random>

namespace anatomesh::plane_sides_test {
namespace {

// Planes of one direction say the same as a stack and as planes in any position.
TEST(PlaneSides, a_stack_is_planes_like_others) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> at(-1, 1);
    PlaneSides stack, planes;
    stack.stack.frame = make_plane({}, {0.3, -0.2, 1});
    stack.on_plane_mm = planes.on_plane_mm = 0.01;
    for (const double height : {-0.5, 0.0, 0.3}) {
        stack.stack.heights.push_back(height);
        planes.planes.push_back(stack.stack.frame);
        planes.planes.back().origin = height * stack.stack.frame.normal;
        planes.extents.push_back({{-9, -9}, {9, 9}});
    }
    int kept = 0;
    for (int n = 0; n < 10000; ++n) {
        Vec3 from{at(random), at(random), at(random)};
        const Vec3 to = from + 0.3 * Vec3{at(random), at(random), at(random)};
        if (n % 4 == 0) from = from - stack.stack.frame.signed_distance(from) * stack.stack.frame.normal;
        EXPECT_EQ(stack.keeps(from, to), planes.keeps(from, to));
        kept += planes.keeps(from, to);
    }
    EXPECT_GT(kept, 1000);
    EXPECT_LT(kept, 9000);
}

TEST(PlaneSides, beyond_its_extent_a_plane_is_nothing_to_pass_through) {
    PlaneSides sides;
    sides.planes.push_back(make_plane({0, 0, 2}, {0, 0, 1}));
    const Plane& plane = sides.planes.front();
    Box2 extent;
    for (const Vec3 corner : {Vec3{0, 0, 2}, Vec3{4, 6, 2}}) extent.extend(plane.to_plane(corner));
    sides.extents.push_back(extent);
    EXPECT_FALSE(sides.keeps({1, 1, 1}, {1, 1, 3}));
    EXPECT_FALSE(sides.keeps({1, 1, 3}, {1, 1, 1}));
    EXPECT_TRUE(sides.keeps({5, 1, 1}, {5, 1, 3}));
    EXPECT_TRUE(sides.keeps({1, 1, 1}, {1, 1, 1.9}));
    // By where it passes, not by where it comes from.
    EXPECT_FALSE(sides.keeps({5, 1, 1}, {1, 1, 5}));
    EXPECT_TRUE(sides.keeps({3, 1, 1}, {7, 1, 3}));
    // What lies in it stays there, and may move within it.
    EXPECT_FALSE(sides.keeps({1, 1, 2}, {1, 1, 2.1}));
    EXPECT_TRUE(sides.keeps({1, 1, 2}, {2, 1, 2}));
    // Just out of the tolerance, far to the side.
    sides.on_plane_mm = 0.01;
    EXPECT_FALSE(sides.keeps({1, 1, 2.009}, {3, 1, 2.011}));
    EXPECT_TRUE(PlaneSides{}.keeps({1, 1, 2}, {9, 9, 9}));
}

}  // namespace
}  // namespace anatomesh::plane_sides_test
