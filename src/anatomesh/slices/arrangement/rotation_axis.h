// rotation_axis: the line that slices were turned about.
#pragma once

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// A line; its direction of unit length.
struct Axis {
    Vec3 origin, direction;
    // How far planes that all run beside it on one side are from it at most, between the ends of the contours
    // along it; 0 of planes that run through it, or here and there.
    double beside = 0;
};

// Planes beside an axis leave room about it, which none passes: they tell something so many times as far off
// as they are beside it. [distances beside the axis; > 1; M 2026-11 planes beside their axis]
inline constexpr double reach_across_axis = 3;

// Least along the planes' normals, and nearest to all planes in the sense of least squares; or, where that
// leaves less than a quarter of what planes are off, such that all pass it at one distance on one side and
// lean against it by one angle, as the slices of a probe do whose image lies beside its axis, or leans
// against it: these are turned by half a turn and no more, from any of them on. That needs eight planes, none
// of them by more than 60 degrees from the next. Requires: a contour. The origin is the point of the line
// nearest to the middle of the contours' box. Complexity: O(slices^2).
Axis rotation_axis(const ContourSet& set);

}  // namespace anatomesh
