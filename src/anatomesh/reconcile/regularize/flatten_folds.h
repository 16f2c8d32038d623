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
// and bounds next to nothing: no model can follow that but with crumbs. Stretches of a contour that are
// narrow (ends near each other and little area for their length) and were not when drawn are replaced by the
// segment between their ends, the longest first; then single points that became sharp corners, below 75
// degrees, of blunt ones, the sharpest first: what crossing slices pulled apart, if the movement made at
// least half of the corner's height or that is less than 0.1 mm over the points beside it. Points that other
// contours have too (shared walls, common points of crossing slices) stay, and so does a point between two of
// them. A slice that would not be sound afterwards keeps its contours. `moved` holds the points that were
// drawn, in any order; others count as moved like the point before them. The set's points are laid out anew.
// Complexity: O(n log n), and per fold O(points of its contour x points within the longest stretch).
FoldStats flatten_folds(ContourSet& set, std::vector<MovedPoint> moved, const FoldOptions& options);

}  // namespace anatomesh
