// chosen_slices: a contour set with some of its slices.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/contour/contour_set.h"

namespace anatomesh {

// Of the set; structures keep their numbers, also those that are no longer drawn. Slices come in the order
// given. Complexity: O(points).
ContourSet chosen_slices(const ContourSet& set, std::span<const std::uint32_t> slices);

}  // namespace anatomesh
