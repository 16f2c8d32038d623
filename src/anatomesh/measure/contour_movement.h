// contour_movement: how far contours are from where they were drawn.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/report.h"

namespace anatomesh {

// Compares contours after slices were made to agree with the same before. What counts is the shape: how far the
// vertices of either are from the contours of the same structure and slice of the other. So a fold that was cut
// off counts, and a vertex that slid along its contour does not. A contour that came or went as a whole counts
// by half of its size. The bound is a share of the slices' spacing (contract::moved_share_of_spacing).
// Requires: both have the same slices and structures. Complexity: O(points), and for vertices that differ
// O(points of the slice) with a small factor.
ContourMovementReport contour_movement(const ContourSet& drawn, const ContourSet& kept);

}  // namespace anatomesh
