#include "anatomesh/geom/parallel_planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace anatomesh::parallel_planes_test {
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

// At any heights of the planes, even ones, clustered ones and several at one height, and of the points, those
// of planes among them.
TEST(ParallelPlanes, the_planes_below_a_height_are_those_that_bisection_finds) {
    std::mt19937 random(5);
    for (int n = 0; n < 300; ++n) {
        const std::size_t count = 1 + random() % 60;
        const double jitter = n % 3 == 0 ? 0 : 0.3, power = n % 4 == 0 ? 5 : 1;
        ParallelPlanes planes;
        for (std::size_t k = 0; k < count; ++k) {
            const double even = static_cast<double>(k) + jitter * (random() % 1000) / 1000.0;
            planes.heights.push_back(n % 5 == 0 ? std::floor(even / 3) : std::pow(even, power));
        }
        std::sort(planes.heights.begin(), planes.heights.end());
        std::vector<double> heights = planes.heights;
        const double infinity = std::numeric_limits<double>::infinity();
        for (const double plane : planes.heights) {
            heights.push_back(std::nextafter(plane, -infinity));
            heights.push_back(std::nextafter(plane, infinity));
        }
        std::uniform_real_distribution<double> any(planes.heights.front() - 2, planes.heights.back() + 2);
        for (int k = 0; k < 50; ++k) heights.push_back(any(random));
        for (const double far : {-1e300, 1e300, -infinity, infinity}) heights.push_back(far);
        for (const double height : heights) {
            const auto below = std::count_if(planes.heights.begin(), planes.heights.end(),
                                             [&](double plane) { return plane < height; });
            ASSERT_EQ(planes.count_below(height), static_cast<std::uint32_t>(below)) << height;
        }
    }
}

TEST(ParallelPlanes, all_is_below_none) {
    EXPECT_EQ(ParallelPlanes{}.count_below(0), 0u);
    EXPECT_EQ(ParallelPlanes{}.level({1, 2, 3}, 0.1), 0u);
}

}  // namespace
}  // namespace anatomesh::parallel_planes_test
