// mirrored_frame: the frame of a slice, carried on to the next slice.
#pragma once

#include "anatomesh/geom/plane.h"

namespace anatomesh {

// Returns the plane of `to` with the frame that `from` has, mirrored in the plane half-way between both. For planes
// that cross it is the frame turned about their common line, for parallel ones the frame moved along the normal.
// Requires: the normals run the same way, less than 180 degrees apart.
// Source: rotation minimizing frames by reflection, Wang, Juettler, Zheng and Liu, ACM Trans. Graph. 27, 2008.
Plane mirrored_frame(const Plane& from, const Plane& to);

}  // namespace anatomesh
