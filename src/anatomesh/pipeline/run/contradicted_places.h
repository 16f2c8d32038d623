// contradicted_places: where slices that cross draw a structure otherwise on their common line.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/refine/section_points.h"

namespace anatomesh {

// Those longer than contradiction_mm (contradicted_segments.h), of slices that say where the structure is:
// `weights` at structure * slices + slice is 0 where one does not. No surface can have the cuts of both
// slices there. In order of pairs and structures. Complexity: that of compare_planes() (line_intervals.h).
std::vector<ContradictedPlace> contradicted_places(const ContourSet& contours,
                                                   std::span<const double> weights, RunContext& context);

}  // namespace anatomesh
