// The structure field of planes in any position. Reached through make_structure_field().
#pragma once

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// Every plane is a finite patch: the box of its contours and a margin, beyond which it says nothing. A point
// takes the clamped in-plane signed distances of its projections onto the patches within a radius R, with
// weights (R - r) / (R r), r its distance from the patch, less for patches behind nearer ones; between two
// parallel patches it is the field of parallel_field.h. A patch that runs along a boundary, where those
// across tell that it is nearer than distances in the patch say, takes the less, and counts less
// (obliquity.h). On a patch itself it alone counts. Beyond the last plane of a sweep its region goes on for
// half the local spacing, or ends (`flat`); elsewhere points that see patches on one side only fade to
// outside. Of a structure of which a patch says nothing (slice_coverage.h) the others alone tell. Requires:
// at least one contour. See docs/stages/05b-field-of-other-arrangements.md. Complexity: a query is linear in
// the patches within R, of which the nearest 16 count; building is linear in the planes, the cells near them
// and the nodes on them.
Result<std::shared_ptr<const StructureField>> make_general_field(const ContourSet& set,
                                                                 const SliceCoverage& coverage,
                                                                 const FieldOptions& options,
                                                                 RunContext& context);

}  // namespace anatomesh
