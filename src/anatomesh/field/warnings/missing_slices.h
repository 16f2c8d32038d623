// warn_about_missing_slices: gaps between slices that follow one another without being parallel.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/rotation_axis.h"

namespace anatomesh {

// W-FLD-001, once, for five slices or more of which neighbours are further apart than 2.5 times what three in
// four are not: held by hand - all lean by 30 degrees at most against their mean - along that mean, through
// the middle of the contours; or turned about an axis (rotation_axis.h) through the contours' box, about
// this, where all run within a twentieth of its diagonal of it. The widest gap is named: planes in any
// position (general_field.h) go on there as far as planes on both sides are seen, and end elsewhere.
// `axis`: rotation_axis(set). Complexity: O(slices log slices).
void warn_about_missing_slices(const ContourSet& set, const Axis& axis, RunContext& context);

}  // namespace anatomesh
