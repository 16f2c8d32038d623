// split_at_endpoints: contours get a vertex where they pass through another slice's plane elsewhere than
// that.
#pragma once

#include <span>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// Puts a vertex into the contours at every end of a comparison whose slices differ on their line, so that a
// movement can take just that place to where it belongs: between vertices that are far apart it cannot. A
// segment that contours of several structures share gets it in all of them. None nearer to a vertex than
// 0.1 mm, and none in a slice that would not be sound with them. Returns their number. The set's points
// are laid out anew, in the same order. O(n + ends log ends) and a check of slices.
std::size_t split_at_endpoints(ContourSet& set, std::span<const LineComparison> comparisons);

// The same at any places inside segments.
std::size_t split_at_places(ContourSet& set, std::span<const IntervalEndpoint> places);

}  // namespace anatomesh
