// split_at_endpoints: contours get a vertex where they pass another slice's plane and the two slices
// differ.
#pragma once

#include <span>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// Puts a vertex into the contours at every endpoint of a comparison whose slices differ. A movement can
// then take just that place to where it belongs, which it cannot between vertices that are far apart. A
// segment that contours of several structures share gets the vertex in all of them. No vertex comes nearer
// to another one than 0.1 mm, and none is put into a slice that would not be sound with it. Returns the
// number of new vertices. The set's points are reindexed, in the same order. O(n + endpoints log
// endpoints) and a check of slices.
std::size_t split_at_endpoints(ContourSet& set, std::span<const LineComparison> comparisons);

// Does the same at any places inside segments.
std::size_t split_at_places(ContourSet& set, std::span<const IntervalEndpoint> places);

}  // namespace anatomesh
