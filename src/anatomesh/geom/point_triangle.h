// The distance of a point from a triangle or a segment.
#pragma once

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Both give the distance from p to the closed triangle (a, b, c), which may be degenerate, in the units of the
// coordinates; the first gives its square. The result is rounded. O(1). Source: Ericson, Real-Time Collision Detection,
// 2005, section 5.1.5.
double point_triangle_squared_distance(Vec3 p, Vec3 a, Vec3 b, Vec3 c);
double point_triangle_distance(Vec3 p, Vec3 a, Vec3 b, Vec3 c);

// Returns the same for the closed segment (a, b), whose ends may be equal.
double point_segment_distance(Vec3 p, Vec3 a, Vec3 b);

}  // namespace anatomesh
