// find_displaced_slices: single slices of a stack or sweep whose contours lie aside of those on both sides.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct DisplacedSlice {
    std::uint32_t slice = 0, structure = 0;
    double distance_mm = 0;  // of the middle of its region from where those of the slices beside put it
};

// A slice on which everything that can be judged lies aside: a jump of the tracking, a breath, a contour that was copied
// to the wrong place. The middle of a structure's region is compared with the line between those on the slices before
// and after. The region is displaced where all of this holds:
// - It lies off that line by 2 mm, by a tenth of its radius (of the circle of its area) and by five times what is usual
//   of the eight slices around, but for the two beside.
// - The slices beside lie on one line without it, to a third of that.
// - The three regions have as many parts and holes, and its area is within a quarter of theirs.
// - Its box has moved as its middle did, to 35 % of that distance: what branches, opens or bulges moves too.
// A slice is not judged if fewer than three slices around can be judged.
// The first two slices of a structure and the last two are not judged, and two in a row that jumped together are not
// found. A slice is given for the structure that is furthest off, and only if most of its structures that can be judged
// are displaced. Slices without a common normal (common_normal.h) have none.
// Returns them in order of slices. Complexity: O(points + slices log slices) for each structure.
std::vector<DisplacedSlice> find_displaced_slices(const ContourSet& set);

}  // namespace anatomesh
