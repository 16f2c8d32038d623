// flatten_folds: contours that a movement has folded onto themselves lose the folds.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// A point of a moved contour, and where it was drawn.
struct MovedPoint {
    Vec3 at, drawn;
};

struct FoldOptions {
    double longest_mm = 40;  // how far apart, along a contour, the ends of a fold are looked for. mm, > 0
    std::vector<bool> keeps_spikes{};  // by slice, but for needles; empty: none
};

struct FoldStats {
    std::uint64_t folds = 0, spikes = 0, vertices = 0;  // taken out
    double highest_mm = 0;  // of a vertex taken out above the segment in its place
};

// Where a movement brings the sides of a notch together, the contour goes out and comes back beside itself
// and bounds next to nothing. No model can follow that without spurious components.
//
// A fold is a stretch of a contour that is narrow and was not when drawn: its ends are near each other,
// and it bounds little area for its length. It is replaced by the segment between its ends, the longest
// fold first. A spike is a single point that became a corner below 75 degrees and was blunt before; the
// sharpest is removed first. The movement must have made at least half of its height, or the spike is
// lower than 0.1 mm.
//
// Points that other contours have too stay (shared walls, common points of crossing slices), and so does a
// point between two of them. A slice that would not be sound afterwards keeps its contours. `moved` holds
// the points that were drawn, in any order; any other point counts as moved like the one before it. The
// set's points are reindexed. Complexity: O(n log n), and per fold O(points of its contour x points within
// the longest stretch).
FoldStats flatten_folds(ContourSet& set, std::vector<MovedPoint> moved, const FoldOptions& options);

}  // namespace anatomesh
