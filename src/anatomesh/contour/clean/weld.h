// weld_contours: vertices of different structures that differ by rounding become equal.
#pragma once

#include <cstdint>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct WeldStats {
    std::uint64_t moved = 0;  // points that took an earlier point's coordinates
    double max_displacement_mm = 0;
};

// A point nearer than `tolerance_mm` to a point of an earlier structure, but not equal to it, takes that point's
// coordinates. Walls that two structures share often differ by the last digits that a file writes; two vertices
// there would force edges of nanometres. Two points of one structure are never made equal.
// Complexity: O(n). Requires: tolerance_mm > 0.
WeldStats weld_contours(ContourSet& set, double tolerance_mm);

}  // namespace anatomesh
