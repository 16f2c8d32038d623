// The structure field of overlapping structures of which the first keeps what they have in common. Reached
// through make_structure_field().
#pragma once

#include <memory>

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// Structures that lie in no other are parted between the slices as their contours are, walls and all; so are
// those that lie in one of these, by themselves, and so on. Of all of them at a point the first in order has
// it: the value of each is the larger of its own and of those before it, of other levels, with the other sign
// (constructive solid geometry: Ricci, Comput. J. 16, 1973). A wall between two outlines is what is between
// their surfaces, however thin it is and however far they move from slice to slice. Guarantees: on every
// slice the region is that of the set's own contours, but for structures of which it says nothing
// (covering_slices.h: slices that draw others alone); at most one structure is negative at a point. Requires:
// set.overlapping. Errors: those of make_structure_field(). Complexity of a query: that of the fields of the
// levels, for all structures near.
Result<std::shared_ptr<const StructureField>> make_nested_field(const ContourSet& set,
                                                                const SliceFacts& slices,
                                                                const FieldOptions& options,
                                                                RunContext& context);

}  // namespace anatomesh
