// reindex_points: contours of a set get other points; in_order_of: contours come back in an earlier order.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Gives every contour, in the set's order, the points of its entry. Requires: one entry a contour. O(n).
void reindex_points(ContourSet& set, std::span<const std::vector<Vec3>> of_contours);

// Returns the set with its contours in the order of those of another set of the same slices, by points
// that both have. Returns nothing where a contour has no such point. O(n log n).
std::optional<ContourSet> in_order_of(const ContourSet& order, const ContourSet& set);

}  // namespace anatomesh
