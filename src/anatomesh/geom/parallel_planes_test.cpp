#include "anatomesh/geom/parallel_planes.h"

#include <gtest/gtest.h>

namespace anatomesh {
namespace {

TEST(ParallelPlanes, a_point_is_in_a_plane_or_between_two) {
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{1, 2, -3}, Vec3{-1, 0.1, 0}}) {
        const ParallelPlanes planes{make_plane({1, 2, 3}, normal), {-2, 0, 0.5}};
        const auto level = [&](double height) {
            return planes.level(planes.frame.origin + 7.0 * planes.frame.u + height * planes.frame.normal,
                                1e-6);
        };
        EXPECT_EQ(level(-100), 0u);
        EXPECT_EQ(level(-2), 1u);
        EXPECT_EQ(level(-2 + 1e-7), 1u);
        EXPECT_EQ(level(-2 - 1e-7), 1u);
        EXPECT_EQ(level(-1e-3), 2u);
        EXPECT_EQ(level(0), 3u);
        EXPECT_EQ(level(0.25), 4u);
        EXPECT_EQ(level(0.5), 5u);
        EXPECT_EQ(level(9), 6u);
    }
}

TEST(ParallelPlanes, all_is_below_none) {
    EXPECT_EQ(ParallelPlanes{}.level({1, 2, 3}, 0.1), 0u);
}

}  // namespace
}  // namespace anatomesh
