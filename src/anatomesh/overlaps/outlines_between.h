// outlines_between: outlines of structures on slices that draw others alone, and overlaps given with these.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/overlaps/priority.h"

namespace anatomesh {

// A structure that is drawn on slices of its own (covering_slices.h) gets on those between them, which say
// nothing of it, the outline that its field alone has there: what its own slices tell. Its vertices lie about
// as far from each other as those that were drawn, or a 48th of a contour. Where the structure is in pieces
// no outline joins them, nor where its slices are further apart than `max_gap_spacings` (structure_field.h),
// nor is there one beyond the last slice of a piece; one smaller than the square of half that is left out.
// Requires: a kept set of parallel slices, not exclusive. Guarantees: a kept set, of the same slices, that
// say which outlines were not drawn (Slice::interpolated); contours of different structures may cross, what
// was drawn stays. Errors: those of make_structure_field(). Complexity: that of a field of each such
// structure, and of a value on a lattice of those distances on each slice.
Result<ContourSet> outlines_between(const ContourSet& set, const FieldOptions& options, RunContext& context);

// give_overlaps(), and where structures that exclude each other are drawn on slices of their own, that of
// what outlines_between() makes of them (W-PRI-002): else a slice of one would say that the others are not
// there, and part them. On such a slice the first in order keeps what both have too, though one of the two
// outlines was not drawn. Not where what was drawn stays beside (`overlapping`) and each level's own slices
// tell enough; nor of voxels, or of planes that are not parallel: there every slice tells. Errors: those of
// give_overlaps() and make_structure_field().
Result<PriorityResult> part_structures(const ContourSet& set, const std::vector<std::uint32_t>& order,
                                       const FieldOptions& options, RunContext& context);

// What of the set was drawn: without outlines that were not, and no longer exclusive, for no slice that has
// none of a structure says by that that it is not there. The set itself where all were drawn.
ContourSet drawn_alone(const ContourSet& set);

}  // namespace anatomesh
