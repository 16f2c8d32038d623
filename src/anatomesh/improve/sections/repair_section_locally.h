// repair_section_locally: the surfaces of structures pass through the planes of slices along what is drawn
// there alone.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

struct LocalRepairStats {
    std::uint64_t places_found = 0;  // facets that pass through a plane, or lie in it, where a cut is not
                                     // what is drawn
    std::uint64_t vertices_moved = 0, cells_relabelled = 0, edges_flipped = 0, edges_collapsed = 0,
                  vertices_inserted = 0;
    std::vector<std::uint32_t> changed;  // cells that were made or reshaped; some may be gone again
    std::vector<std::uint32_t> left;     // cells at facets that meet a plane still
};

// Where the contours are edges of the surface, a facet of it that passes through a slice's plane, or lies in
// it beside the drawn region, or one within a region that lies in it between contours, is all that can make
// the model's cut another one than what is drawn. At each such facet the first of these is
// done that makes what is wrong in the cuts of the cells concerned (slice_sections.h) half as much or
// less: a free vertex is moved off the plane or across it; a cell is relabelled to the region across the
// facet; the edge of the surface across the plane is flipped; a free vertex goes along such an edge onto its
// other end, which may move for the shape of the cells there; the two cells at a facet in the plane are
// filled from a new vertex beside it; where the cut comes near to the 0.1 % that it may be wrong by, the
// surface leaves a free vertex beyond the plane for a new one this side of it. The two cells at a facet
// within a region are given to one beside them, together.
// What was moved and what is new is fixed from then on for all others, and here when it was moved once more.
// Guarantees: all cells positive (checked exactly); cells made or reshaped inside keep the edit context's
// target and bound, or, where that can't be and the cut comes near to the 0.1 % that it may be wrong by, have
// no angle whose sine is below `least_sine` and no ratio above the last bound, or than there was; no vertex
// moved, no edge collapsed and no cell relabelled brings a surface further from the field's than the
// edit context's `spike_mm`, or than it was, and a new vertex stays within the cells at its facet, or within
// `spike_mm` of the field's surface; the surfaces of all structures keep their topology and their contours.
// Same result every time. Complexity: O(cells), where these are not parallel times their number, and its
// square at each facet that is wrong. After 10,000 places in vain the rest stays as it is, and of places at a
// price after as many: where slices contradict each other and are kept so, no surface can have all their
// cuts. Errors: none; a cancelled run stops. `look`: the cells whose facets are looked at, in any order,
// repeats and such that are gone allowed; null: all.
LocalRepairStats repair_section_locally(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                        const RunContext& context,
                                        const std::vector<std::uint32_t>* look = nullptr);

}  // namespace anatomesh
