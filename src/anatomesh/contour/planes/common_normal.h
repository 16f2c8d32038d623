// common_normal: the direction along which slices follow one another, though they may lean or cross.
#pragma once

#include <optional>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Returns the mean of the slices' normals, all taken to one side. Returns nothing where one leans by more than 30
// degrees against it, or there are no slices. Complexity: O(slices).
std::optional<Vec3> common_normal(const ContourSet& set);

}  // namespace anatomesh
