// enforce_clearance: contours that movement brought nearly to touch come apart again.
#pragma once

#include <cstdint>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/original_positions.h"

namespace anatomesh {

struct ClearanceStats {
    std::uint64_t places = 0;
    double farthest_mm = 0;  // that a contour gave way
};

// A vertex and a segment nearly touch if the movement brought them nearer than half of `least_mm`. Both
// belong to contours of one structure on a slice, or of any two where structures exclude each other. No
// cell fits between such contours. The vertex moves away from the segment to `least_mm`, or to the
// distance at which they were drawn if that is less. A vertex that lies in the plane of another slice
// stays, and the segment gets a vertex that moves instead.
//
// What contours share stays shared. A slice that would not be sound keeps a place as it is. `drawn` is
// kept up. Requires: a kept contour set, least_mm > 0. Guarantees: a kept contour set, by exact
// predicates. Complexity: O(n log n) and O(points of the slice + slices) a place.
ClearanceStats enforce_clearance(ContourSet& set, OriginalPositions& drawn, double least_mm);

}  // namespace anatomesh
