// fit_along: where a contour lies along a normal, and how far its points lie off that plane.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include "anatomesh/contour/planes/plane_grouping.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

inline constexpr std::array<Vec3, 3> coordinate_axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
inline constexpr std::array<int, 3> axial_first{2, 1, 0};  // the axes in the order in which they are tried

// Times the noise, what points may be off a plane fitted to them. [1; >= 1; D a choice, measurement not recorded]
inline constexpr double fitted_share = 1.25;
// So many points show how far off a plane of their own they are; fewer always lie near one.
// [points; > 3; D a choice, measurement not recorded]
inline constexpr std::size_t least_points_of_a_plane = 8;

// The plane across a normal that points lie near.
struct PlaneFit {
    double offset = 0;  // of the plane along the normal: the lower median of the points
    double deviation = std::numeric_limits<double>::infinity();  // of the point furthest off it
    double low = 0, high = 0;                                    // of the points along the normal
};

// Returns the plane across `normal` that most points lie near. Guarantees: single points off the plane do not move it.
// Requires: points, a unit normal. Complexity: O(points).
PlaneFit fit_along(std::span<const Vec3> points, Vec3 normal);

// Returns the axis along which the contour lies at one coordinate, or -1. It does if three quarters of its points have
// the same coordinate to the bit, and the rest lies within `allowed_mm` of it. Requires: points. Complexity: O(points).
int axis_at_one_coordinate(std::span<const Vec3> points, double allowed_mm);

// Returns the root mean square distance of points from the plane that they show themselves; 0 for so few that they
// always lie near one. Complexity: O(points).
double noise_off_own_plane(std::span<const Vec3> points);

// Returns how far rounding to 0.1, 0.01 or 0.001 mm has moved points off their planes at most; 0 where the coordinates
// show no such rounding. Contours with a declared plane are not looked at. Complexity: O(points).
double coordinate_rounding(std::span<const ContourToPlace> contours);

}  // namespace anatomesh
