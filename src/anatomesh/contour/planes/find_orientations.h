// find_orientations: which contours lie in parallel planes, and the normal of those planes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/planes/contour_orientation.h"
#include "anatomesh/contour/planes/plane_grouping.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

// Orientations, and which one each contour has.
struct ContourOrientations {
    std::vector<Orientation> all;
    std::vector<std::int32_t> of_contour;  // an index into `all`; -1: not known yet
};

// Returns the orientations of the contours that have a declared plane; the others are not known yet. Declared normals
// that differ by less than `tolerance_mm` at their contours' extent are one: that of the most points.
// Complexity: O(points + planes x orientations).
ContourOrientations declared_orientations(std::span<const ContourToPlace> contours,
                                          std::span<const Plane> declared, double tolerance_mm);

// Returns the orientations of all contours, `known` ones first.
// - Contours at one x, y or z have that axis, if they make up a tenth of the area: fewer are an accident of a tilted
//   stack.
// - Of the rest the largest comes first, since it shows its plane best. Each joins the orientation that it fits, or
//   has one of its own.
// - Contours that neither fit an orientation nor lie on a plane of their own come last. They join what they fit within
//   `tolerance.repair_mm`.
// Normals are not refined yet. `area`: of each contour. Guarantees: each contour has an orientation.
// Complexity: O(points x orientations + contours log contours).
ContourOrientations find_orientations(std::span<const ContourToPlace> contours, std::span<const double> area,
                                      const PlaneTolerance& tolerance, ContourOrientations known);

}  // namespace anatomesh
