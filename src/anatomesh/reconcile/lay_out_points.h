// lay_out_points: contours of a set get other points.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/contour/contour_set.h"

namespace anatomesh {

// The points of every contour, in the set's order, become these. Requires: one entry a contour. O(n).
void lay_out_points(ContourSet& set, std::span<const std::vector<Vec3>> of_contours);

}  // namespace anatomesh
