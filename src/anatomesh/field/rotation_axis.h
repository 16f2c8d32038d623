// rotation_axis: the line that slices were turned about.
#pragma once

#include "anatomesh/contour/contour_set.h"

namespace anatomesh {

// A line; its direction of unit length.
struct Axis {
    Vec3 origin, direction;
};

// Least along the planes' normals, and nearest to all planes in the sense of least squares; or, where that
// leaves less than a quarter of their distances, as far from all of them on one side, as the slices of a
// probe are whose image lies beside its axis: these are turned by half a turn and no more, from any of them
// on. That needs eight planes. Requires: a slice. The origin is the point of the line nearest to the middle
// of the contours' box. Complexity: O(slices^2).
Axis rotation_axis(const ContourSet& set);

}  // namespace anatomesh
