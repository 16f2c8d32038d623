// make_stack_field: the field of slices that are parallel, or a sweep.
#pragma once

#include <memory>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

// The field of parallel slices (parallel_field.h) or of a sweep (swept_field.h); nullptr where the slices are neither.
// Requires and errors: as make_structure_field().
Result<std::shared_ptr<const StructureField>> make_stack_field(const ContourSet& set,
                                                               const SliceArrangement& arrangement,
                                                               const FieldOptions& options,
                                                               RunContext& context);

}  // namespace anatomesh
