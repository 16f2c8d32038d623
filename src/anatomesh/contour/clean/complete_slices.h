// warn_about_complete_slices: what a file says of slices that it calls complete, where that is doubtful.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Of a complete set of parallel slices, else nothing. Warns: W-FLD-003, once a structure, of slices between its first
// and its last without it, which are empty because the file says so; W-FLD-014, once, of slices that are further apart
// than two of them are thick. Requires: a kept contour set. O(slices * structures + contours).
void warn_about_complete_slices(const ContourSet& set, RunContext& context);

}  // namespace anatomesh
