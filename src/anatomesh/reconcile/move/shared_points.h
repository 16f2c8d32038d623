// Corresponding ends as groups that become one point, and that point as a common vertex of the contours.
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

// Puts the groups' points into all contours that have a place of the group: a place on a vertex moves it
// there, one inside a segment splits that. Only groups whose places are within 0.05 mm of the point across
// their contours - on one line but for fewer than a third of them, slices that could not be brought there,
// which get no point -; and none that would make a slice unsound. A vertex that lies within 0.03 mm of the
// point that comes beside it gives way to it, where `moved` (of every point of the set) says that it is no
// longer as drawn: an edge so short forces cells a hundredth of the others' size. Where three slices or more
// meet in a point, those of all their pairs that are as near to each other become that one. The set's points
// and contours are laid out anew, in the same order.
SharedPoints insert_shared_points(ContourSet& set, std::span<const LineComparison> comparisons,
                                  const std::vector<bool>& moved);

}  // namespace anatomesh
