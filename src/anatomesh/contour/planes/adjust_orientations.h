// refine_normals, separate_crossing_planes: orientations that were found contour by contour, seen over all contours.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/contour/planes/find_orientations.h"

namespace anatomesh {

// Gives the contours of each orientation their common normal: the least-squares normal of all of them. Noise turns the
// normal of a stack a little. Where points lie off their planes by more than `plane_tolerance_mm`, an axis that fits
// about as well is taken. Fixed orientations stay.
// Requires: each contour has an orientation. Complexity: O(points).
void refine_normals(std::span<const ContourToPlace> contours, double plane_tolerance_mm,
                    ContourOrientations& orientations);

// Gives contours orientations of their own that do not lie in the plane of theirs, or whose planes cross or nearly do.
// Contours with a declared plane stay, and those that `stays` says. Requires: each contour has an orientation.
// Complexity: O(points + contours log contours).
void separate_crossing_planes(std::span<const ContourToPlace> contours, const PlaneTolerance& tolerance,
                              const std::vector<bool>& stays, ContourOrientations& orientations);

}  // namespace anatomesh
