// Handles on solids of unit cubes.
#include "anatomesh/mesh/check/small_handles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "anatomesh/mesh/model/cube_solid_for_test.h"

namespace anatomesh::small_handles_test {
namespace {

using fixtures::CubeSolid;

constexpr double wide = 1000;

CubeSolid block() {
    CubeSolid solid;
    solid.add({0, 0, 0}, {24, 12, 12});
    return solid;
}

// On the block's upper side.
void add_arch(CubeSolid& solid, int x, int legs_apart = 1) {
    solid.add({x, 5, 12}, {x + 1, 6, 14});
    solid.add({x + 1 + legs_apart, 5, 12}, {x + 2 + legs_apart, 6, 14});
    solid.add({x, 5, 14}, {x + 2 + legs_apart, 6, 15});
}

std::uint32_t count(std::span<const SmallHandles> found) {
    return std::accumulate(found.begin(), found.end(), 0u,
                           [](std::uint32_t sum, const SmallHandles& part) { return sum + part.handles; });
}

std::vector<SmallHandles> handles_of(CubeSolid& solid, double reach) {
    const std::vector<Triangle> surface = solid.surface();
    return small_handles(solid.points(), surface, reach);
}

TEST(SmallHandles, of_all_that_is_within_reach_are_the_genus) {
    for (int arches = 0; arches <= 4; ++arches) {
        for (int channels = 0; channels <= 3; ++channels) {
            CubeSolid solid = block();
            for (int n = 0; n < arches; ++n) add_arch(solid, 1 + 5 * n);
            for (int n = 0; n < channels; ++n) solid.remove({4 + 6 * n, 0, 3}, {5 + 6 * n, 12, 4});
            EXPECT_EQ(count(handles_of(solid, wide)), static_cast<std::uint32_t>(arches + channels));
        }
    }
}

TEST(SmallHandles, are_found_where_they_are_apart_from_each_other) {
    for (int arches = 0; arches <= 4; ++arches) {
        CubeSolid solid = block();
        solid.remove({22, 0, 3}, {23, 12, 4});  // a channel through all of it
        for (int n = 0; n < arches; ++n) add_arch(solid, 1 + 5 * n);
        const std::vector<SmallHandles> found = handles_of(solid, 6);
        EXPECT_EQ(count(found), static_cast<std::uint32_t>(arches));
        for (const SmallHandles& part : found) {
            const Vec3 at = solid.points()[part.middle];
            EXPECT_GT(at.z, 8);
            EXPECT_TRUE(std::is_sorted(part.vertices.begin(), part.vertices.end()));
            EXPECT_TRUE(std::binary_search(part.vertices.begin(), part.vertices.end(), part.middle));
        }
    }
}

TEST(SmallHandles, are_none_where_the_way_along_them_is_far) {
    CubeSolid solid = block();
    add_arch(solid, 2, 12);
    EXPECT_EQ(count(handles_of(solid, 6)), 0u);
    EXPECT_EQ(count(handles_of(solid, 24)), 1u);
}

TEST(SmallHandles, are_none_on_bumps_dents_corners_and_voids) {
    CubeSolid solid = block();
    solid.add({3, 3, 12}, {5, 5, 15});
    solid.remove({8, 3, 10}, {10, 5, 12});
    solid.remove({14, 5, 5}, {16, 7, 7});
    solid.add({22, 10, 10}, {26, 14, 13});
    for (const double reach : {1.0, 2.0, 4.0, 8.0, 16.0, wide})
        EXPECT_TRUE(handles_of(solid, reach).empty()) << reach;
}

}  // namespace
}  // namespace anatomesh::small_handles_test
