// slices_out_of_line: single slices of a stack or sweep whose contours are shifted against those on both
// sides.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct OutOfLine {
    std::uint32_t slice = 0, structure = 0;
    double distance_mm = 0;  // of the middle of its region from where those of the slices beside put it
};

// A slice on which everything that can be judged lies aside: a jump of the tracking, a breath, a contour that
// was copied to the wrong place. The middle of a structure's region is compared with the line between those
// on the slices before and after. It is out of line where it lies off by 2 mm, by a tenth of the region's
// radius (of the circle of its area) and by five times what is usual of the eight slices around, but for the
// two beside; where the slices beside are in line without it, to a third of that; and where the three regions
// have as many parts and holes, its area is within a quarter of theirs, and its box has moved as its middle
// did, to a third: what branches, opens or bulges moves too. The first two slices of a structure and the last
// two are not judged, and two in a row that jumped together are not found. A slice is given for the structure
// that is furthest off, and only if most of its structures that can be judged are out of line. Of slices that
// all lean by 30 degrees at most against their mean; none of others. In order of slices. Complexity: O(points
// + slices log slices) for each structure.
std::vector<OutOfLine> slices_out_of_line(const ContourSet& set);

}  // namespace anatomesh
