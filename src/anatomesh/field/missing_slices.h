// warn_about_missing_slices: gaps between slices that follow one another without being parallel.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/contour_set.h"

namespace anatomesh {

// W-FLD-001, once, for slices held by hand: where all planes lean by 30 degrees at most against their mean
// and there are five or more of them, and along that mean, through the middle of the contours, neighbours are
// further apart than 2.5 times what three in four gaps do not exceed. The widest gap is named: planes in any
// position (general_field.h) go on there as far as planes on both sides are seen, and end elsewhere.
// Complexity: O(slices log slices).
void warn_about_missing_slices(const ContourSet& set, RunContext& context);

}  // namespace anatomesh
