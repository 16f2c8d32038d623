// merge_layers: contours that were traced from several label maps of one image, as one set.
#pragma once

#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Slices of equal plane become one slice. Structures of different layers may overlap. Requires: at least one
// set; kept sets of one geometry, with no structure number twice. Guarantees: a kept contour set. Complexity:
// O(points + n log n) in the slices and structures.
ContourSet merge_layers(std::vector<ContourSet> layers);

}  // namespace anatomesh
