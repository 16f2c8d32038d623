// paths_of_slices: the paths that slices follow, where each is drawn across one of some tubes.
#pragma once

#include <cstdint>
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
// Slices of a tube that turns by 60 degrees or more may lean by up to 25 degrees so that they cross others beside them,
// as planes that were set by eye do. So few of them as may be, a third of all at most, are then on no path: each lies in
// a gap of a path and draws about as much as the slices around it. Where a hand leads a probe it turns by less.
// In the order of their first slices. Complexity: O(slices^2 + points of slices that cross).
std::optional<std::vector<SlicePath>> paths_of_slices(const ContourSet& set);

// Slices with a part that has no neighbour on either side, rising. O(slices^2).
std::vector<std::uint32_t> slices_without_neighbor(const ContourSet& set);

}  // namespace anatomesh
