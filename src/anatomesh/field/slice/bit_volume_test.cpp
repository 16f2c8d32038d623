#include "anatomesh/field/slice/bit_volume.h"

#include <gtest/gtest.h>

#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/slice/distance_map.h"

namespace anatomesh::bit_volume_test {
namespace {

using namespace fixtures;

TEST(BitVolume, agrees_with_the_sign_of_the_distance_map) {
    std::mt19937 random(21);
    for (const std::uint32_t nx : {63u, 64u, 65u, 200u}) {
        const PixelGrid grid{{-31.7, -29.3}, {64.0 / nx, 0.43}, nx, 140};
        BitVolume volume(grid, 3);
        std::uint64_t inside = 0;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::vector<Edge2> edges =
                edges_of({star({0, 0}, 10, 28, 40, random), reversed(star({0, 0}, 2, 9, 15, random))});
            const DistanceMap map(edges, 2.0);
            volume.fill(k, edges);
            for (std::uint32_t j = 0; j < grid.ny; ++j) {
                for (std::uint32_t i = 0; i < grid.nx; ++i) {
                    const Vec2 q = grid.low + Vec2{i * grid.step.x, j * grid.step.y};
                    ASSERT_EQ(volume.inside(i, j, k), map.value(q) < 0) << i << " " << j << " " << k;
                    inside += volume.inside(i, j, k);
                }
            }
            EXPECT_EQ(volume.count(), inside);
        }
    }
}

// Voxel centres exactly on the boundary: two regions that share a wall share out its voxels, each once.
TEST(BitVolume, C15_voxels_on_a_shared_wall_belong_to_one_side) {
    const PixelGrid grid{{0, 0}, {1, 1}, 130, 5};
    BitVolume left(grid, 1), right(grid, 1);
    left.fill(0, edges_of({{{0, 0}, {64, 0}, {64, 4}, {0, 4}}}));
    right.fill(0, edges_of({{{64, 0}, {128, 0}, {128, 4}, {64, 4}}}));
    EXPECT_EQ(left.count(), 64u * 4);
    EXPECT_EQ(right.count(), 64u * 4);
    for (std::uint32_t i = 0; i < 128; ++i) EXPECT_NE(left.inside(i, 2, 0), right.inside(i, 2, 0));
    EXPECT_EQ(left.bytes(), 3u * 5 * 8);
}

TEST(BitVolume, regions_beyond_the_grid_are_cut_off) {
    const PixelGrid grid{{0, 0}, {1, 1}, 10, 10};
    BitVolume volume(grid, 1);
    volume.fill(0, edges_of({{{-50, -50}, {50, -50}, {50, 50}, {-50, 50}}}));
    EXPECT_EQ(volume.count(), 100u);
    BitVolume none(grid, 1);
    none.fill(0, edges_of({{{20, 20}, {30, 20}, {30, 30}}}));
    EXPECT_EQ(none.count(), 0u);
}

}  // namespace
}  // namespace anatomesh::bit_volume_test
