// The structure field of overlapping structures of which the first keeps what they have in common. Reached
// through make_structure_field().
#pragma once

#include <memory>

#include "anatomesh/field/structure_field.h"

namespace anatomesh {

// Each structure between the slices as it was drawn, less those before it there: the larger of its own value
// and of theirs with the other sign (constructive solid geometry: Ricci, Comput. J. 16, 1973). A wall between
// two outlines is what is between their surfaces, however thin it is and however far they move from slice to
// slice. Structures that touch and do not overlap go on by themselves between the slices. Guarantees: on
// every slice the region is that of the set's own contours; at most one structure is negative at a point.
// Requires: set.overlapping. Errors: those of make_structure_field(). Complexity of a query: that of the
// field of what was drawn, for all structures near.
Result<std::shared_ptr<const StructureField>> make_nested_field(const ContourSet& set,
                                                                const FieldOptions& options,
                                                                RunContext& context);

}  // namespace anatomesh
