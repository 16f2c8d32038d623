// regularize_along_axis: contours that run along a line in which many planes meet, beside it, are made one
// surface.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/original_positions.h"

namespace anatomesh {

struct AlongAxisOptions {
    double radius_mm = 1;       // from the line: contours nearer to it are moved. mm, > 0
    double least_degrees = 70;  // between the surface's two sides at a contour; less is regularized. (0, 180)
    double most_moved_mm = 10;  // of a vertex from where it was drawn. mm, > 0
};

// By slice, how far its flanks may move: no further than its contours had to move elsewhere, for one that
// agreed as it was drawn has no flanks that noise made.
using AlongAxisBounds = std::vector<double>;

struct AlongAxisStats {
    std::uint64_t points = 0;  // that were moved
    double farthest_mm = 0;
};

// A *flank* is a part of a structure's contour that runs along a line in which four planes or more meet
// (nowhere steeper than 60 degrees) and is the first thing beside it in its half plane. Nearer to the line
// than `radius_mm` neighbouring planes are nearer to each other than contours can be drawn, and flanks that
// lie near to it and far from it in turn leave fins and slits that no cells fit into. Where the surface's two
// sides, as they go to the flanks of the two half planes beside it, make an angle below the least at a flank,
// it is moved to or from the line, each time half way to where the chord between those two passes its plane,
// until it is none, lies at the radius or has moved as far as its slice's bound, at most 50 times. Flanks get
// vertices for that, about a radius apart. (At the line's poles, see regularize_fans.h.)
//
// Requires: a kept contour set with common points (insert_shared_points); `drawn` of it. Guarantees: points
// that other slices have too, and those at which contours branch, keep their bits; no contour comes to or
// over the line; contours that structures share stay shared; a slice that would not be sound keeps its
// contours. The set's points are laid out anew, in the same order, and `drawn` with them. Complexity: O(s^3)
// for s slices to find the lines, small; then O(flanks' points times those of a half plane beside the line).
// No earlier method is followed.
AlongAxisStats regularize_along_axis(ContourSet& set, OriginalPositions& drawn,
                                     const AlongAxisBounds& most_mm, const AlongAxisOptions& options);

}  // namespace anatomesh
