// make_field_of_slices: the field of structures that do not take each other's place, by how their slices lie.
#pragma once

#include <memory>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// As make_structure_field(), but `set.overlapping` is not looked at. Requires: at least one contour.
Result<std::shared_ptr<const StructureField>> make_field_of_slices(const ContourSet& set,
                                                                   const SliceFacts& slices,
                                                                   const FieldOptions& options,
                                                                   RunContext& context);

}  // namespace anatomesh
