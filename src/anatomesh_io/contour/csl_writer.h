// Writes the CSL of csl_reader.h.
#pragma once

#include <string>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// A contour that runs clockwise is written as a hole of the smallest outer contour of its structure that
// holds it. Requires and guarantees: those of format_contours (write_contours.h). Complexity: linear, but for
// slices with holes: (holes x outer contours) of a structure, in their points.
std::string format_csl(const ContourSet& set);

}  // namespace anatomesh
