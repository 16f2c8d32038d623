#include "anatomesh/contour/planes/displaced_slices.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "anatomesh/contour/cleaned_for_test.h"

namespace anatomesh::displaced_slices_test {
namespace {

using namespace fixtures;

// An organ on `count` slices 3 mm apart whose outline's middle and radius follow the height.
ContourSet organ(int count, const std::function<Vec3(int)>& middle_and_radius) {
    File file;
    for (int k = 0; k < count; ++k) {
        const Vec3 at = middle_and_radius(k);
        file.add(circle(at.x, at.y, at.z, 50, 3.0 * k));
    }
    return clean(file).kept();
}

std::vector<std::uint32_t> slices_of(const ContourSet& set) {
    std::vector<std::uint32_t> slices;
    for (const DisplacedSlice& one : find_displaced_slices(set)) slices.push_back(one.slice);
    return slices;
}

Vec3 ball(int k) {
    return {0, 0, std::sqrt(30.0 * 30 - 9 * (k - 8) * (k - 8))};
}

TEST(DisplacedSlices, C29_a_slice_that_jumped_is_named_with_its_distance) {
    for (const double jump : {4.0, 8.0, 12.0, 40.0}) {
        for (const int at : {3, 8, 12}) {
            const ContourSet set = organ(17, [&](int k) { return ball(k) + Vec3{k == at ? jump : 0, 0, 0}; });
            const std::vector<DisplacedSlice> found = find_displaced_slices(set);
            ASSERT_EQ(found.size(), 1u) << jump << " " << at;
            EXPECT_EQ(found[0].slice, static_cast<std::uint32_t>(at));
            EXPECT_NEAR(found[0].distance_mm, jump, 0.05);
        }
    }
}

TEST(DisplacedSlices, what_leans_bends_winds_trembles_or_jumps_for_good_is_not) {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 0.7);
    EXPECT_TRUE(slices_of(organ(17, ball)).empty());
    EXPECT_TRUE(slices_of(organ(17, [](int k) { return ball(k) + Vec3{2.5 * k, -1.0 * k, 0}; })).empty());
    EXPECT_TRUE(slices_of(organ(17, [](int k) { return Vec3{0.2 * (k - 8) * (k - 8), 0, 8}; })).empty());
    EXPECT_TRUE(slices_of(organ(17, [](int k) {
                    return Vec3{12 * std::cos(0.7 * k), 12 * std::sin(0.7 * k), 5};
                })).empty());
    EXPECT_TRUE(slices_of(organ(17, [&](int k) {
                    return ball(k) + Vec3{noise(random), noise(random), 0};
                })).empty());
    EXPECT_TRUE(slices_of(organ(17, [](int k) { return ball(k) + Vec3{k < 8 ? 0.0 : 10.0, 0, 0}; })).empty());
    EXPECT_TRUE(slices_of(organ(4, [](int k) { return Vec3{k == 2 ? 9.0 : 0, 0, 20}; })).empty());
}

TEST(DisplacedSlices, a_process_on_one_slice_or_a_part_that_is_larger_there_is_not) {
    File process, kidneys;
    for (int k = 0; k < 15; ++k) {
        Points outline = circle(0, 0, 18, 60, 5.0 * k);
        if (k % 7 == 3) {
            for (Vec3& p : outline) p.x = p.x > 15 ? p.x + 20 : p.x;
        }
        process.add(outline);
        for (const double side : {-60.0, 60.0})
            kidneys.add(circle(side, 0, k == 7 && side > 0 ? 22.2 : 20, 50, 5.0 * k));
    }
    EXPECT_TRUE(slices_of(clean(process).kept()).empty());
    EXPECT_TRUE(slices_of(clean(kidneys).kept()).empty());
}

TEST(DisplacedSlices, one_of_several_structures_that_lies_aside_alone_is_its_own_shape) {
    File file;
    for (int k = 0; k < 17; ++k) {
        for (std::uint32_t s = 0; s < 2; ++s)
            file.add(circle(60.0 * s + (k == 8 && s == 0 ? 10 : 0), 0, 20, 50, 3.0 * k), s);
    }
    EXPECT_TRUE(slices_of(clean(file).kept()).empty());
    File together;
    for (int k = 0; k < 17; ++k) {
        for (std::uint32_t s = 0; s < 2; ++s)
            together.add(circle(60.0 * s + (k == 8 ? 10 : 0), 0, 20, 50, 3.0 * k), s);
    }
    EXPECT_EQ(slices_of(clean(together).kept()), std::vector<std::uint32_t>{8});
}

}  // namespace
}  // namespace anatomesh::displaced_slices_test
