// reindex_points: contours of a set get other points; in_order_of: and come back in their order.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// The points of every contour, in the set's order, become these. Requires: one entry a contour. O(n).
void reindex_points(ContourSet& set, std::span<const std::vector<Vec3>> of_contours);

// The set with its contours in the order of those of another one, of the same slices, that have points of
// theirs; nothing where one has none. O(n log n).
std::optional<ContourSet> in_order_of(const ContourSet& order, const ContourSet& set);

}  // namespace anatomesh
