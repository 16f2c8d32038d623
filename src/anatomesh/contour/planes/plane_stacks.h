// plane_stacks: contours in parallel planes in their order, and how near each other planes are one (gap clustering).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/planes/find_orientations.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

// A contour with its position along the normal of its stack.
struct PositionedContour {
    double offset = 0;
    std::uint32_t contour = 0;
    std::size_t points = 0;
};

// The contours of one orientation, in the order of their offsets; never none.
struct PlaneStack {
    Vec3 normal;
    std::vector<PositionedContour> contours;
};

// Returns the stacks in the lexicographic order of their normals. A contour is where most of its points are, or where
// its declared plane passes its middle. Requires: each contour has an orientation.
// Complexity: O(points + contours log contours).
std::vector<PlaneStack> plane_stacks(std::span<const ContourToPlace> contours,
                                     std::span<const Plane> declared,
                                     const ContourOrientations& orientations);

// Returns how near each other planes of a stack are one plane given twice, at most `bound_mm`. That is 2 % of the
// largest gap; for two planes, of which one gap does not say what is usual, it is 1e-3 of the extent. `extent_mm`: of
// all contours. Complexity: O(stack).
double same_plane_mm(std::span<const PositionedContour> stack, double extent_mm, double bound_mm);

// Returns the plane that a run of contours shares: at the offset that half of their points reach, with the foot of
// (0, 0, 0) as its origin. Requires: a run. Complexity: O(run).
Plane common_plane(std::span<const PositionedContour> run, Vec3 normal);

}  // namespace anatomesh
