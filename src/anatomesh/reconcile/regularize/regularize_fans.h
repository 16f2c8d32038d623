// regularize_fans: where many planes meet in a line, the contours beside it are made one surface.
#pragma once

#include <cstdint>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/original_positions.h"

namespace anatomesh {

struct FanOptions {
    double radius_mm = 1;       // up to where contours are turned. mm, > 0
    double least_degrees = 70;  // between the surface's two sides at a contour; less is regularized. (0, 180)
    double most_moved_mm = 10;  // of a vertex from where it was drawn. mm, > 0
    double steepest_degrees =
        65;  // of a leg over the plane across the line; steeper ones are turned. (0, 90]
};

struct FanStats {
    std::uint64_t poles = 0;  // that were regularized
    double highest_mm = 0;    // of a turn, at its radius
};

// A *pole* is a point of contours of four planes or more that share a line, on that line; its *legs* are the
// parts of a structure's contours that go out from it, one into each half plane. Beside the line neighbouring
// planes are nearer to each other than contours can be drawn: legs that rise and fall in turn leave fins and
// slits that no cells fit into. Where the facets between a leg and those of the two planes beside it make an
// angle below the least, all legs of the pole are turned about it in their planes, each half way to the facet
// between its neighbours, until none is sharper, at most 50 times: what rises and falls from plane to plane
// goes, a slope over several planes stays; so does a leg that would turn by less than 3 degrees. Before
// that, legs steeper than the steepest are turned as far as that: a surface that runs nearly along the line
// has legs of many planes within a few degrees of each other, and cells between them are needles. Legs are
// turned up to the radius, where they get a vertex, or up to less: a third of the way to the next point that
// other slices have too, or at which contours branch. A leg that has less than half the radius for that stays
// as it is, and (unless they are fewer than half) the others keep their room.
//
// Requires: a kept contour set with common points (insert_shared_points); `drawn` of it. Guarantees: poles
// and all other common points keep their bits; contours that structures share stay shared; a slice that would
// not be sound keeps its contours; points within the radius keep their distance from the pole. The set's
// points are laid out anew, in the same order, and `drawn` with them. O(n log n), a check of the slices that
// change, and 50 turns a leg. No earlier method is followed.
FanStats regularize_fans(ContourSet& set, OriginalPositions& drawn, const FanOptions& options);

}  // namespace anatomesh
