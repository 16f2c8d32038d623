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

// Where a vertex has come nearer to a segment of its structure's contours on the slice (of any structure's,
// where they exclude each other) than half of `least_mm`, and was not so when drawn, it goes away from the
// segment to that distance, or to the one it was drawn at; one that lies in the plane of another slice stays,
// and the segment gets a vertex that goes. No cell fits between contours that all but touch, and movement
// that is shortened where contours would cross leaves them so. What contours share stays shared. A slice that
// would not be sound keeps a place as it is. `drawn` is kept up. Requires: a kept contour set, least_mm > 0.
// Guarantees: a kept contour set, by exact predicates. O(n log n) and O(points of the slice + slices) a
// place.
ClearanceStats enforce_clearance(ContourSet& set, OriginalPositions& drawn, double least_mm);

}  // namespace anatomesh
