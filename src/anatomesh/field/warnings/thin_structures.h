// warn_about_thin_structures: what planes that cross cannot tell.
#pragma once

#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Twice the area of each structure's sections over the length of their outlines, mm: the radius of a circle,
// the width of a strip. 0 for what is not drawn. Complexity: O(points).
std::vector<double> mean_thicknesses(const ContourSet& set);

// W-FLD-007 for every structure that is drawn thinner in the mean (twice its area over its outline's length)
// than `spacing` mm, which its planes are apart: what joins its sections is not known. Complexity: O(points).
void warn_about_thin_structures(const ContourSet& set, double spacing, RunContext& context);

}  // namespace anatomesh
