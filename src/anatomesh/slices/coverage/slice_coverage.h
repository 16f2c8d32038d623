// slice_coverage: which slices of a contour set say something about a structure that they do not draw.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// By slice of a set of parallel slices or a sweep, whether it says something about the structure: all do in a
// set whose structures exclude each other (a label map), and where all from the structure's first to its last
// do; else those that covering_slices() names. Of structures that lie in each other (overlaps/priority.h)
// what was drawn says it, level by level: slices that a level has none of say nothing. Of planes that cross
// by the first rule, in the order of the set. Complexity: O(contours + slices log slices), that of
// Sweep::of().
std::vector<bool> slice_coverage(const ContourSet& set, std::uint32_t structure);

}  // namespace anatomesh
