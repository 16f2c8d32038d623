// insert_shared_points: the point of each group of corresponding endpoints becomes a common vertex of the
// contours.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

struct SharedPoints {
    std::uint64_t points = 0;  // groups that became a point of all their contours
};

// Puts the groups' points into all contours that have a place of the group. A place on a vertex moves the
// vertex there, and a place inside a segment splits that. A group gets its point only if its places are
// within 0.05 mm of it, across their contours. On a single line fewer than a third of the places may be
// further away; slices that could not be brought there get no point. No point is put in that would make a
// slice unsound.
//
// A vertex within 0.03 mm of a point beside it gives way to the point if it is no longer as drawn. `moved`
// says so for every point of the set. An edge so short forces cells a hundredth of the others' size. A vertex
// as drawn gives way within 1/200 of its contour's mean segment and 1/10 of its own: what a file of few
// decimals leaves beside each other was one vertex. It stays where other contours have it too. Where
// three slices or more meet in a point, the points of all their pairs that are as near to each other become
// one. The set's points are reindexed, in the same order. Complexity: O(n log n), and a check of each slice
// for each point that it cannot have.
SharedPoints insert_shared_points(ContourSet& set, std::span<const LineComparison> comparisons,
                                  const std::vector<bool>& moved);

}  // namespace anatomesh
