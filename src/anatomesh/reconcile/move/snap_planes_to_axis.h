// Planes and points as they were before a file rounded them.
#pragma once

#include <cstdint>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Planes about an axis, fitted to points of a text of few decimals, pass their axis within this distance.
// [mm; > 0; M 2026-11 ellipsoid of 36 planes rounded to 0.01 mm]
inline constexpr double rounded_plane_mm = 0.05;

struct PlaneSnappingStats {
    std::uint32_t about_axis = 0;  // planes that were led through one axis
    std::uint64_t points = 0;      // put onto their planes
    double farthest_mm = 0;        // of them
};

// Where contours come from a text of few decimals their points lie beside their planes, and planes about an
// axis, fitted to such points, beside that: then each pair of slices meets at another place, micrometres from
// the next, and no vertex can be common to all. So planes of which more than half, and at least five, run
// through one line within 0.05 mm as far as the box of all contours reaches along it, are turned to run
// through it exactly (the line nearest to all, in the sense of least squares), where no point of the slice
// comes to lie farther than that from its plane; and points go onto their planes, along the normal. What is
// exact stays as it is. Requires: a kept set. Same result for any order of its slices but for rounding.
// Complexity: O(points + slices^2).
PlaneSnappingStats snap_planes_to_axis(ContourSet& set);

}  // namespace anatomesh
