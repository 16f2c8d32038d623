// paths_of_slices: the paths that slices follow, where each is drawn across one of some tubes.
#pragma once

#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/slice_path.h"

namespace anatomesh {

// Vessels and other tubes are drawn on planes normal to their paths: arches, helices, branches. What such a slice
// says ends beside its own contours, because its plane cuts other tubes, or the same one elsewhere.
//
// Two slices are neighbours where they share a structure, what each draws lies on one side of the other, the boxes of their
// contours lie before each other, and each is the nearest of the other on that side. Chains of neighbours are the
// paths. Nothing is returned, and the slices are planes in any position:
// - where a slice with contours has no neighbour, or a chain is closed;
// - where two slices of one path draw the same place: they are planes that cross;
// - where slices that lean by less than 10 degrees reach through each other, as those that a hand leads do;
// - where slices of two paths that share a structure do so, unless it is a branch and its root: the places lie in the
//   half of one path at its end, and on no more than half of the other one's slices; the slices lean by 10 degrees at
//   least, and below 25 degrees do not agree on what they draw there, as those of one body would;
// - where structures exclude each other.
// In the order of their first slices. Complexity: O(slices^2 + points of slices that cross).
std::optional<std::vector<SlicePath>> paths_of_slices(const ContourSet& set);

}  // namespace anatomesh
