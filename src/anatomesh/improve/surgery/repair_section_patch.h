// repair_section_patch: what a cut by a slice's plane has too much or too little of a structure goes to its
// other side as a whole.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/core/quality_gate.h"

namespace anatomesh {

struct PatchRepairStats {
    std::uint64_t patches_found = 0, patches_repaired = 0, spurious_components_removed = 0;
    std::vector<std::uint32_t> changed;  // cells that were made or reshaped, some of which may be gone
};

// Repairs what remains where one cell after the other does not do (repair_section_locally.h). Sections of
// cells that are wrong, of one region and beside each other, are a patch in a slice's plane. For each
// cross-section that comes near to the 0.1 % that it may be wrong by, the worst first, and each patch in it:
// 1. The edges that pass through the patch are cut there, so that it is a membrane of facets. Where a vertex
//    is near the plane, that is taken for one of the patch.
// 2. The neighbourhood of the membrane is relabelled to the other side of the structure
//    (relabel_membrane_neighborhood.h).
// 3. `improve` works on the shapes, and the change stays or is undone (membrane_surgery.h).
//
// A change stays only if all of these hold:
// - Surfaces of structures and regions are one disc at each vertex concerned.
// - The structure keeps its Euler characteristic, or loses a handle or a tunnel. If the cross-section is
//   wrong by more than 0.1 %, the structure may also fall into parts, each with a vertex of a contour of
//   its; and parts of it, or of what is not it, that were apart may be joined.
// - No contour vertex or subsegment leaves the surface of its structure.
// - The cross-section loses half of what is wrong in the patch. No other one gets worse by as much, or comes
//   near to 0.1 %.
// - Interfaces there are as near to the field's as they were, or within the edit context's `spike_mm`, and
//   changed cells inside are as good as quality_gate.h demands.
// - No more cells than before, or than 0.3 % of those inside, are above the edit context's first bound.
//
// `look`: nothing is wrong but in cells that share a vertex with one of these, in any order, such that are
// gone allowed; null: in any. Guarantees: all cells positive (checked exactly); no vertex moves but by
// `improve`. Same result every time. Complexity: O(cells) for each cross-section concerned and each patch
// repaired, and the shapes of the cells of a hundred patches tried in vain at most; where planes cross, of
// 5,000 cells for one cross-section and 20,000 in all. Errors: none; a cancelled run stops.
PatchRepairStats repair_section_patch(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                      const ImproveCells& improve, const RunContext& context,
                                      const std::vector<std::uint32_t>* look = nullptr);

}  // namespace anatomesh
