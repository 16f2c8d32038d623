// regularize_fans: the contours that leave a point of a line in which many planes meet are made one
// surface.
#pragma once

#include <cstdint>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/original_positions.h"

namespace anatomesh {

struct FanOptions {
    double radius_mm = 1;  // Contours are turned up to this distance from the line. mm, > 0
    // A smaller angle between the surface's two sides at a contour is regularized. (0, 180)
    double least_degrees = 70;
    // No vertex comes further from where it was drawn. mm, > 0
    double most_moved_mm = 10;
    double steepest_degrees =
        65;  // of a ray over the plane across the line; steeper ones are turned. (0, 90]
};

struct FanStats {
    std::uint64_t fans = 0;  // that were regularized
    double highest_mm = 0;   // of a turn, at its radius
};

// A *pole* is a point on a line of four planes or more at which their contours pass that line. The parts of
// a structure's contours that leave it, one into each half plane, are the *rays* of its *fan*. Beside the
// line neighbouring planes are nearer to each other than anybody draws. Rays that rise and fall in turn
// leave fins and slits there that no cells fit into.
//
// A pole is regularized where the facets from a ray to its two neighbours make an angle below the least.
// All rays of the pole turn about it in their planes, each half way to the facet between its neighbours,
// until no angle is sharper or 50 times. What rises and falls from plane to plane is evened out by this,
// and a slope over several planes stays. A ray that would turn by less than 3 degrees stays. Before that,
// rays steeper than the steepest are turned to it: rays nearly along the line lie within a few degrees of
// each other, and cells between them are needles.
//
// Rays turn as far as the radius and get a vertex there. Where another slice's point or a branching of
// contours is near, they turn up to a third of the way to it. A ray with less than half the radius of room
// stays, and does not limit the others unless fewer than half of the rays have more.
//
// Requires: a kept contour set with common points (insert_shared_points); `drawn` of it. Guarantees: poles
// and all other common points keep their bits, and contours that structures share stay shared. A slice
// that would not be sound keeps its contours. Points within the radius keep their distance from the pole.
// The set's points are reindexed in the same order, and `drawn` with them. Complexity: O(n log n), a check
// of the slices that change, and 50 turns a ray. No earlier method is followed.
FanStats regularize_fans(ContourSet& set, OriginalPositions& drawn, const FanOptions& options);

}  // namespace anatomesh
