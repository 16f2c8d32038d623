// The structure field of parallel slices. Reached through make_structure_field().
#pragma once

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

// Requires: parallel slices, at least one contour. See make_structure_field() and docs/stages/05-field.md.
Result<std::shared_ptr<const StructureField>> make_parallel_field(const ContourSet& set,
                                                                  const FieldOptions& options,
                                                                  RunContext& context);

}  // namespace anatomesh
