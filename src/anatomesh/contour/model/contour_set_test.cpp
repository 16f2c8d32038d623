#include "anatomesh/contour/model/contour_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace anatomesh::contour_set_test {
namespace {

ContourSet stack(const std::vector<double>& positions, Vec3 normal) {
    ContourSet set;
    for (const double position : positions) {
        Slice slice;
        slice.plane = make_plane(position * normalized(normal), normal);
        slice.first_contour = static_cast<std::uint32_t>(set.contours.size());
        slice.contour_count = 1;
        set.contours.push_back({0, static_cast<std::uint32_t>(set.slices.size()),
                                static_cast<std::uint32_t>(set.points.size()), 3});
        for (const Vec2 q : {Vec2{0, 0}, Vec2{60, 0}, Vec2{0, 80}})
            set.points.push_back(slice.plane.to_space(q));
        set.slices.push_back(slice);
    }
    return set;
}

TEST(ContourSet, parallel_up_to_sign_and_within_the_tolerance_at_its_outermost_point) {
    ContourSet set = stack({0, 3, 6}, {0.1, -0.3, 1});
    EXPECT_TRUE(all_parallel(set, 0));
    set.slices[1].plane.normal = -set.slices[1].plane.normal;
    EXPECT_TRUE(all_parallel(set, 0));

    set = stack({0, 3}, {0, 0, 1});
    const double angle = 1e-3;
    set.slices[1].plane.normal = {std::sin(angle), 0, std::cos(angle)};
    const double move = std::sin(angle) * set.box().diagonal() / 2;
    EXPECT_TRUE(all_parallel(set, move * 1.01));
    EXPECT_FALSE(all_parallel(set, move * 0.99));
    EXPECT_TRUE(all_parallel(ContourSet(), 0));
}

TEST(ContourSet, spacing_is_the_median_of_the_gaps_in_any_order) {
    EXPECT_EQ(median_spacing(ContourSet()), 0);
    EXPECT_EQ(median_spacing(stack({5}, {0, 0, 1})), 0);
    EXPECT_EQ(median_spacing(stack({0, 3, 6, 9, 19}, {0, 0, 1})), 3);
    EXPECT_EQ(median_spacing(stack({9, 0, 19, 3, 6}, {0, 0, 1})), 3);
    EXPECT_NEAR(median_spacing(stack({0, 2.5, 5, 20}, {1, 2, -0.5})), 2.5, 1e-12);
}

TEST(ContourSet, a_slice_at_the_same_position_opens_no_gap) {
    EXPECT_EQ(median_spacing(stack({0, 0, 0, 0, 3, 6}, {0, 0, 1})), 3);
    EXPECT_EQ(median_spacing(stack({4, 4}, {0, 0, 1})), 0);
    EXPECT_NEAR(median_spacing(stack({100, 100 + 1e-12, 103, 106}, {0, 0, 1})), 3, 1e-9);
    // A plane given again a little off itself.
    EXPECT_NEAR(median_spacing(stack({0, 0.1, 2, 2.1, 4, 4.1, 6}, {0, 0, 1})), 1.9, 1e-9);
    EXPECT_NEAR(median_spacing(stack({0, 0.1}, {0, 0, 1})), 0.1, 1e-9);
}

}  // namespace
}  // namespace anatomesh::contour_set_test
