// warn_about_displaced_slices: single slices that lie aside of those on both sides.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Warns W-FLD-011 once, with the names of all slices that find_displaced_slices() finds and the distance of the worst.
// It does not where that one was told in this context: it may be found again in a part of a set. For contours that
// somebody drew. Complexity: as there.
void warn_about_displaced_slices(const ContourSet& set, RunContext& context);

}  // namespace anatomesh
