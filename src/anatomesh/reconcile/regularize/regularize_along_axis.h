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

// By slice, how far its contours along an axis may move: no further than its contours had to move elsewhere. A
// slice that agreed as it was drawn has none that noise made.
using AlongAxisBounds = std::vector<double>;

struct AlongAxisStats {
    std::uint64_t points = 0;  // that were moved
    double farthest_mm = 0;
};

// A *stretch along the axis* is a part of a structure's contour that runs along a line of four planes or
// more, nowhere steeper than 60 degrees. It is the first thing beside the line in its half plane. Within `radius_mm` of the line
// neighbouring planes are nearer to each other than anybody draws. Stretches that lie near to the line and far
// from it in turn leave fins and slits there that no cells fit into.
//
// At a stretch the surface has two sides, which go to the stretches of the half planes beside it. Where they
// make an angle below the least, the stretch moves to or from the line, half way to where the chord between
// those two stretches passes its plane. That is repeated until the angle is wide enough, or the stretch lies at
// the radius or has moved as far as its slice's bound; 50 times at most. Stretches get vertices for this,
// about a radius apart. regularize_fans.h does the same where contours pass the line.
//
// Requires: a kept contour set with common points (insert_shared_points); `drawn` of it. Guarantees:
// points that other slices have too, and those at which contours branch, keep their bits. No contour comes
// to or over the line, and contours that structures share stay shared. A slice that would not be sound
// keeps its contours. The set's points are reindexed in the same order, and `drawn` with them. Complexity:
// O(s^3) for s slices to find the lines, with a small factor; then O(stretches' points times those of a half
// plane beside the line). No earlier method is followed.
AlongAxisStats regularize_along_axis(ContourSet& set, OriginalPositions& drawn,
                                     const AlongAxisBounds& most_mm, const AlongAxisOptions& options);

}  // namespace anatomesh
