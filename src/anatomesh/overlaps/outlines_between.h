// outlines_between: outlines of structures on slices that draw only others; part_structures: priority with
// these outlines.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/overlaps/priority.h"

namespace anatomesh {

// A structure that is drawn on slices of its own (covering_slices.h) gets an outline on the slices between
// them, which say nothing of it. The outline is what the structure's own field has there. Its vertices lie
// about as far from each other as those that were drawn, or a 48th of a contour.
//
// No outline joins separate pieces of a structure, or bridges a gap wider than `max_gap_spacings`
// (structure_field.h), or lies beyond the last slice of a piece. An outline smaller than the square of a
// lattice step is left out. Requires: a kept set of parallel slices, not exclusive. Guarantees: a kept set
// of the same slices, which say which outlines were not drawn (Slice::interpolated). Contours of different
// structures may cross; what was drawn stays. Errors: those of make_structure_field(). Complexity: that of
// a field of each such structure, and of a value on a lattice on each slice.
Result<ContourSet> outlines_between(const ContourSet& set, const FieldOptions& options, RunContext& context);

// Does what give_overlaps() does. Structures that exclude each other may be drawn on slices of their own.
// Then it does so with the outlines of outlines_between() (W-PRI-002), because a slice of one would say that
// the others are absent, and part them. On such a slice the first in order keeps what both have, even if one
// of the outlines was not drawn.
//
// Outlines are not needed where what was drawn stays beside (`overlapping`) and each level has enough
// slices of its own. Nor are they of voxels, or of planes that are not parallel, where every slice says
// something of every structure. Errors: those of give_overlaps() and make_structure_field().
Result<PriorityResult> part_structures(const ContourSet& set, const std::vector<std::uint32_t>& order,
                                       const FieldOptions& options, RunContext& context);

// Returns what of the set was drawn, without interpolated outlines. It is no longer exclusive, because a
// slice without a structure does not say that the structure is absent. Returns the set itself where all
// was drawn. O(points).
ContourSet drawn_alone(const ContourSet& set);

}  // namespace anatomesh
