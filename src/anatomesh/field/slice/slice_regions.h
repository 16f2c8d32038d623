// The drawn regions of a contour set as directed edges in plane coordinates.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/slice/scanline.h"

namespace anatomesh {

// One structure's region in one slice.
struct SliceRegion {
    std::uint32_t slice = 0, structure = 0;
    std::vector<Edge2> edges;  // region on the left
};

// The regions of a slice in the coordinates of `frame` (whose normal may be opposite to the slice's), in
// order of structure. Contours whose area vanishes in double precision are left out. Complexity: linear in
// the points.
std::vector<SliceRegion> slice_regions(const ContourSet& set, std::uint32_t slice, const Plane& frame);

// The boundary of the union of regions that do not overlap: walls that two of them share, edge for edge,
// cancel. Complexity: O(n log n).
std::vector<Edge2> union_boundary(const std::vector<SliceRegion>& regions);

}  // namespace anatomesh
