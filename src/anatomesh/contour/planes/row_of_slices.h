// direction_of_row: whether slices follow one another along one direction, though they may lean or cross.
#pragma once

#include <optional>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// The mean of the slices' normals, all taken to one side; nothing where one leans by more than 30 degrees
// against it, or there are none. O(slices).
std::optional<Vec3> direction_of_row(const ContourSet& set);

}  // namespace anatomesh
