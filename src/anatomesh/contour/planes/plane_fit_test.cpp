// Where contours lie along a normal, and how near each other planes of a stack are one.
#include "anatomesh/contour/planes/plane_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "anatomesh/contour/planes/plane_stacks.h"

namespace anatomesh::plane_fit_test {
namespace {

std::vector<Vec3> square_at(double z) {
    std::vector<Vec3> points;
    for (int i = 0; i < 8; ++i)
        points.push_back({10 * std::cos(0.785 * i + 0.1), 10 * std::sin(0.785 * i + 0.1), z});
    return points;
}

TEST(PlaneFit, a_single_point_off_the_plane_does_not_move_it) {
    std::vector<Vec3> points = square_at(3);
    points[2].z = 3.5;
    const PlaneFit fit = fit_along(points, {0, 0, 1});
    EXPECT_EQ(fit.offset, 3);
    EXPECT_EQ(fit.deviation, 0.5);
    EXPECT_EQ(fit.low, 3);
    EXPECT_EQ(fit.high, 3.5);
}

TEST(PlaneFit, three_quarters_of_the_points_show_an_axis) {
    std::vector<Vec3> points = square_at(3);
    EXPECT_EQ(axis_at_one_coordinate(points, 0), 2);
    points[2].z = points[5].z = 3.5;
    EXPECT_EQ(axis_at_one_coordinate(points, 1), 2);
    EXPECT_EQ(axis_at_one_coordinate(points, 0.1), -1);
    points[6].z = 3.5;
    EXPECT_EQ(axis_at_one_coordinate(points, 1), -1);
}

TEST(PlaneFit, rounding_is_that_of_the_coarsest_step_that_all_coordinates_have) {
    const std::vector<Vec3> coarse{{0.1, 0.5, 3}, {2.2, 0, 3}, {1, 1, 3.1}};
    const std::vector<Vec3> fine{{0.11, 0.5, 3}, {2.2, 0, 3}, {1, 1, 3.1}};
    const std::vector<Vec3> exact = square_at(3);
    const double half_diagonal = 0.5 * std::sqrt(3.0);
    EXPECT_DOUBLE_EQ(coordinate_rounding(std::vector<ContourToPlace>{{coarse}}), half_diagonal * 0.1);
    EXPECT_DOUBLE_EQ(coordinate_rounding(std::vector<ContourToPlace>{{coarse}, {fine}}),
                     half_diagonal * 0.01);
    EXPECT_EQ(coordinate_rounding(std::vector<ContourToPlace>{{coarse}, {exact}}), 0);
    EXPECT_GT(coordinate_rounding(std::vector<ContourToPlace>{{coarse}, {exact, 0}}), 0);
}

TEST(PlaneStacks, planes_are_one_within_a_fiftieth_of_the_largest_gap) {
    const std::vector<PositionedContour> stack{{0, 0, 8}, {0.004, 1, 8}, {0.3, 2, 8}, {0.6, 3, 8}};
    EXPECT_DOUBLE_EQ(same_plane_mm(stack, 20, 0.01), 0.02 * 0.3);
    EXPECT_EQ(same_plane_mm(stack, 20, 0.001), 0.001);
    // Two planes: by the extent of the contours.
    EXPECT_EQ(same_plane_mm(std::span(stack).first(2), 20, 1), 0.02);
}

TEST(PlaneStacks, a_run_lies_where_half_of_its_points_reach) {
    const std::vector<PositionedContour> run{{-2, 0, 3}, {-1, 1, 10}, {5, 2, 4}};
    const Plane plane = common_plane(run, {0, 0, 1});
    EXPECT_EQ(plane.origin, (Vec3{0, 0, -1}));
    EXPECT_FALSE(std::signbit(plane.origin.x));
}

}  // namespace
}  // namespace anatomesh::plane_fit_test
