#include "anatomesh/contour/clean/weld.h"

#include <gtest/gtest.h>

namespace anatomesh::weld_test {
namespace {

ContourSet two_squares(double gap) {
    ContourSet set;
    set.structures = {{1, "left", {}}, {2, "right", {}}};
    set.slices = {{make_plane({}, {0, 0, 1}), 0, 2, "z = 0"}};
    set.points = {{0, 0, 0},       {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                  {1 + gap, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1 + gap, 1, 0}};
    set.contours = {{0, 0, 0, 4}, {1, 0, 4, 4}};
    return set;
}

TEST(Weld, a_wall_drawn_twice_but_for_rounding_becomes_one) {
    for (const double gap : {1e-15, 1e-9, 5e-5}) {
        ContourSet set = two_squares(gap);
        const WeldStats stats = weld_contours(set, 1e-4);
        EXPECT_EQ(stats.moved, 1 + gap == 1 ? 0u : 2u);
        EXPECT_LE(stats.max_displacement_mm, gap + 1e-15);
        EXPECT_EQ(set.points[4], set.points[1]);
        EXPECT_EQ(set.points[7], set.points[2]);
    }
}

TEST(Weld, walls_apart_stay_apart) {
    ContourSet set = two_squares(2e-4);
    EXPECT_EQ(weld_contours(set, 1e-4).moved, 0u);
    EXPECT_EQ(set.points, two_squares(2e-4).points);
}

TEST(Weld, points_of_one_contour_are_never_made_equal) {
    ContourSet set = two_squares(0.5);
    set.points[1] = {5e-5, 0, 0};  // beside points[0], in the same contour
    const std::vector<Vec3> before = set.points;
    EXPECT_EQ(weld_contours(set, 1e-4).moved, 0u);
    EXPECT_EQ(set.points, before);
}

}  // namespace
}  // namespace anatomesh::weld_test
