// contours_in_planes: the contours of a model for a file.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/pipeline/build_model.h"

namespace anatomesh {

// Contours as the model's surface has them. Those that leave their planes by more than the tolerance (mm, >=
// 0) to follow it are as they were drawn, for contours of files lie in planes; and so are those that would
// cross one of these. Guarantees: a kept contour set. Complexity: O(n log n).
ContourSet contours_in_planes(const Model& model, double tolerance_mm);

}  // namespace anatomesh
