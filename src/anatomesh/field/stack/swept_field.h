// The structure field of a sweep of slices. Reached through make_structure_field().
#pragma once

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/arrangement/sweep.h"

namespace anatomesh {

// The field of parallel slices (parallel_field.h) in the sweep's chart coordinates. Requires: sweep of
// `set`, at least one contour.
Result<std::shared_ptr<const StructureField>> make_swept_field(Sweep sweep, const ContourSet& set,
                                                               const FieldOptions& options,
                                                               RunContext& context);

}  // namespace anatomesh
