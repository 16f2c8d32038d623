// Laws of the patches near a point: what a grid finds against all patches looked at one by one.
#include "anatomesh/field/planes/patch_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace anatomesh::patch_grid_test {
namespace {

constexpr double margin = 2, radius = 12;

std::vector<PlanePatch> patches_anywhere(std::size_t count, std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1), size(2, 15);
    std::vector<PlanePatch> patches;
    for (std::size_t n = 0; n < count; ++n) {
        const Plane plane = make_plane({20 * unit(random), 20 * unit(random), 20 * unit(random)},
                                       {unit(random), unit(random), 1.1 + unit(random)});
        const double x = size(random), y = size(random);
        patches.push_back({plane, {{-x, -y}, {x, y}}, -1e-6, 1e-6});
    }
    return patches;
}

double distance_to(const PlanePatch& patch, Vec3 p) {
    return length(patch.offset_from(p, margin));
}

struct Case {
    std::vector<PlanePatch> patches;
    PatchGrid grid;
};

Case case_of(std::size_t count, int threads, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<PlanePatch> patches = patches_anywhere(count, random);
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    PatchGrid grid(patches, all, {{-40, -40, -40}, {40, 40, 40}}, radius, margin, threads);
    return {std::move(patches), std::move(grid)};
}

TEST(PatchGrid, finds_the_nearest_patch_and_none_beyond_the_radius_in_rising_order) {
    for (const std::size_t count : {1u, 5u, 40u, 200u}) {
        const Case given = case_of(count, 1, static_cast<unsigned>(count));
        std::mt19937 random(3);
        std::uniform_real_distribution<double> place(-40, 40);
        for (int n = 0; n < 500; ++n) {
            const Vec3 p{place(random), place(random), place(random)};
            double nearest = radius;
            for (const PlanePatch& patch : given.patches) nearest = std::min(nearest, distance_to(patch, p));
            PatchGrid::Keys keys;
            const std::uint32_t found = given.grid.find_near(p, keys);
            EXPECT_EQ(found > 0, nearest < radius);
            if (found > 0) {
                EXPECT_NEAR(std::sqrt(keys[0].square), nearest, 1e-9);
            }
            for (std::uint32_t k = 0; k < found; ++k) {
                EXPECT_NEAR(std::sqrt(keys[k].square), distance_to(given.patches[keys[k].patch], p), 1e-9);
                EXPECT_LT(keys[k].square, radius * radius);
                EXPECT_TRUE(k == 0 || keys[k - 1].square <= keys[k].square);
            }
        }
    }
}

TEST(PatchGrid, leaves_one_patch_out_where_that_is_asked_for) {
    const Case given = case_of(40, 1, 9);
    PatchGrid::Keys keys;
    for (std::uint32_t n = 0; n < given.patches.size(); ++n) {
        const Vec3 p = given.patches[n].plane.origin;
        ASSERT_GT(given.grid.find_near(p, keys), 0u);
        EXPECT_EQ(keys[0].square, 0);
        const std::uint32_t found = given.grid.find_near(p, keys, n);
        for (std::uint32_t k = 0; k < found; ++k) EXPECT_NE(keys[k].patch, n);
    }
}

TEST(PatchGrid, is_the_same_for_any_number_of_threads_and_empty_beyond_its_box) {
    const Case one = case_of(100, 1, 5), three = case_of(100, 3, 5);
    std::mt19937 random(6);
    std::uniform_real_distribution<double> place(-40, 40);
    PatchGrid::Keys a, b;
    for (int n = 0; n < 500; ++n) {
        const Vec3 p{place(random), place(random), place(random)};
        const std::uint32_t found = one.grid.find_near(p, a);
        ASSERT_EQ(three.grid.find_near(p, b), found);
        for (std::uint32_t k = 0; k < found; ++k) EXPECT_EQ(a[k].patch, b[k].patch);
    }
    EXPECT_EQ(one.grid.find_near({41, 0, 0}, a), 0u);
}

// A patch behind a nearer parallel one of the same size has no share of the view.
TEST(PatchGrid, drops_patches_that_nearer_ones_hide) {
    std::vector<PlanePatch> patches;
    for (int k = 0; k < 12; ++k)
        patches.push_back(
            {make_plane({0, 0, static_cast<double>(k)}, {0, 0, 1}), {{-30, -30}, {30, 30}}, 0, 0});
    std::vector<std::uint32_t> all(patches.size());
    std::iota(all.begin(), all.end(), 0u);
    const PatchGrid grid(patches, all, {{-10, -10, -10}, {10, 10, 20}}, radius, margin, 1);
    PatchGrid::Keys keys;
    ASSERT_EQ(grid.find_near({1, 2, 5.25}, keys), 2u);
    EXPECT_EQ(keys[0].patch, 5u);
    EXPECT_EQ(keys[1].patch, 6u);
}

}  // namespace
}  // namespace anatomesh::patch_grid_test
