// The structure field of slices about an axis. Reached through make_structure_field().
#pragma once

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// The field of parallel slices (parallel_field.h) in the sweep's chart coordinates; near the axis, where
// slices are nearer to each other than vertices along the contours are in the mean, or cross, that of planes
// in any position (general_field.h), which takes the mean of them. From one to the other their values are
// blended, over as far again. The latter alone where a slice says nothing of a structure
// (slice_coverage.h). Requires: slices of `set`, about an axis; at least one contour. Errors: those of both. Complexity of
// a query: that of the field that counts there, of both where they are blended.
Result<std::shared_ptr<const StructureField>> make_rotational_field(const ContourSet& set,
                                                                    const SliceFacts& slices,
                                                                    const FieldOptions& options,
                                                                    RunContext& context);

}  // namespace anatomesh
