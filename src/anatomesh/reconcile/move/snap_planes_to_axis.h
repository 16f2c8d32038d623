// snap_planes_to_axis: planes and points are restored to what they were before a file rounded them.
#pragma once

#include <cstdint>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Planes about an axis, fitted to points of a text of few decimals, pass their axis within this distance.
// [mm; > 0; M 2026-11 ellipsoid of 36 planes rounded to 0.01 mm]
inline constexpr double rounded_plane_mm = 0.05;

struct PlaneSnappingStats {
    std::uint32_t about_axis = 0;  // planes that were led through an axis
    std::uint64_t points = 0;      // put onto their planes
    double farthest_mm = 0;        // of them
};

// A text of few decimals leaves points beside their planes, and planes about an axis that are fitted to
// such points leave their axis. Each pair of slices then meets in a line of its own, micrometres from the
// next, and no vertex can be common to all.
//
// If more than half of the planes, and at least five, pass one line within 0.05 mm, they are turned to
// contain it. The line counts as far as the box of all contours reaches along it, and is the nearest one
// to all by least squares. Of the others three or more that pass one line within 0.002 mm are turned to contain
// that one, each plane about one line only: a fan among stacks. A plane stays where a point of its slice would come to lie farther than 0.05 mm
// from it. Points are then projected onto their planes. What is exact stays as it is.
//
// `mm`: how long a millimetre is in the unit of the set.
//
// Requires: a kept set. Guarantees: the same result for any order of its slices, except for rounding.
// Complexity: O(points + slices^3), and O(points + slices^2) for more than some hundred slices.
PlaneSnappingStats snap_planes_to_axis(ContourSet& set, double mm = 1);

}  // namespace anatomesh
