// The structure field of a stack or sweep with a few planes across it. Reached through
// make_structure_field().
#pragma once

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// Between its slices the stack's own field F. Near one of the others, F in that plane is set against what is
// drawn there: where they differ in sign, or F is the smaller and its surface runs elsewhere in the plane
// than the contours, the difference is carried off the plane, with a weight that falls from 1 on the plane to
// 0 on the stack's slices and at two spacings from the plane (inverse distances: Shepard, Proc. 23rd ACM
// National Conference, 1968). So each plane's contours lie on the surface, and where the planes agree with
// the stack it stays what the stack says. A plane says nothing more than one spacing beside its contours, and
// nothing of structures that it does not draw. Requires: slices of `set`, a stack with planes across it. Complexity of
// a query: that of the stack's field for each plane near, and O(slices) there.
Result<std::shared_ptr<const StructureField>> make_crossed_field(const ContourSet& set,
                                                                 const SliceFacts& slices,
                                                                 const FieldOptions& options,
                                                                 RunContext& context);

}  // namespace anatomesh
