// thin_line: fewer points of a line that a hand or a tool drew.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Returns some of the points, in their order; the first and the last stay. Every point lies within `tolerance_mm` of the
// result. Points equal to the one before go first. Requires: tolerance_mm > 0, finite points. Source and complexity:
// those of thin_chains() (contour/simplify/chains.h).
std::vector<Vec2> thin_line(std::span<const Vec2> line, double tolerance_mm);

// The same where it does not matter how the line crosses itself: as far as possible from each point that stays.
// Complexity: O(n). Source: Chan and Chin, ISAAC 1992 (cones that pass near points).
std::vector<Vec2> thin_path(std::span<const Vec2> path, double tolerance_mm);

// The same as thin_line() for closed polygons that bound one region: they stay simple, apart and nested as they were.
std::vector<std::vector<Vec2>> thin_polygons(std::span<const std::vector<Vec2>> polygons,
                                             double tolerance_mm);

// Returns the line without points equal to the one before. O(n).
std::vector<Vec2> without_repeats(std::span<const Vec2> line);

}  // namespace anatomesh
