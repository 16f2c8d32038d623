// warn_about_outlying_slices: says which slices contradict the slices beside them.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

// Warns of each slice that find_outlying_slices() finds: W-FLD-011 where it is displaced, W-FLD-020 where it differs
// otherwise. The warning says what is wrong, where and by how much, what the structure would be without the slice, and the
// option that leaves it out. Of more than five slices the worst five are told, and the last warning names the others. A slice
// that a warning of crossing slices (W-RCN) names is not told again. For contours that somebody drew; of others nothing
// is said. `options`: of the field of the model. Complexity: that of find_outlying_slices(), and two of
// shape_of_structure() for each slice told.
void warn_about_outlying_slices(const ContourSet& set, const SliceArrangement& arrangement,
                                const FieldOptions& options, RunContext& context);

}  // namespace anatomesh
