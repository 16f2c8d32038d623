// make_structure_field: the field of a contour set, by how its slices lie.
#pragma once

#include <memory>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// Requires: a kept contour set (see ContourSet). The set must outlive nothing: the field copies what it
// needs. Errors: geometry E-FLD-001 no contours, E-FLD-002 none encloses an area, E-FLD-003 a single slice
// without thickness. Parallel slices: exact signed distances to the polygons, clamped and blended along
// the boundary's motion (slice_motion.h); a sweep (sweep.h): the same in chart coordinates; slices about
// an axis: rotational_field.h; a few planes across stacks and sweeps: crossed_field.h; structures that lie in
// others and take their place: nested_field.h. Planes in any position: see docs/stages/05b-field-of-other-arrangements.md.
// `slices`: of the set, with the gap that the options join.
Result<std::shared_ptr<const StructureField>> make_structure_field(const ContourSet& set,
                                                                   const SliceFacts& slices,
                                                                   const FieldOptions& options,
                                                                   RunContext& context);

// The same of a set whose slices nobody has looked at yet.
Result<std::shared_ptr<const StructureField>> make_structure_field(const ContourSet& set,
                                                                   const FieldOptions& options,
                                                                   RunContext& context);

}  // namespace anatomesh
