// The structure field of planes in any position. Reached through make_structure_field().
#pragma once

#include "anatomesh/field/structure_field.h"

namespace anatomesh {

// Every plane is a finite patch: the box of its contours and a margin. A point takes the clamped in-plane
// signed distances of its projections onto the patches within a radius R, weighted with ((R - r) / (R r))^2
// where r is the distance from the patch (Franke and Little's form of Shepard's weights; Franke, Math. Comp.
// 38, 1982): on a patch itself it alone counts. Points that see patches on one side only, beyond the last
// plane of a sweep, fade to outside half a spacing away. Requires: at least one contour. See docs/method.md.
// Complexity: a query is linear in the patches within R.
Result<std::shared_ptr<const StructureField>> make_general_field(const ContourSet& set,
                                                                 const FieldOptions& options,
                                                                 RunContext& context);

}  // namespace anatomesh
