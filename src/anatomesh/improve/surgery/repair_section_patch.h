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

// Where one cell after the other (repair_section_locally.h) does not do: of each cut that comes near to the
// 0.1 % that it may be wrong by, the sections of cells that are wrong, of one region and beside each other,
// are a patch in the plane. The edges that pass through it are cut there - where a vertex is near, that is
// taken for one of the patch -, so that the patch is a membrane of facets, and the membrane's neighbourhood
// is relabelled (relabel_membrane_neighborhood.h): its regular neighbourhood goes to the other side of the
// structure. Then `improve` works on the shapes. All of it is taken back if a surface, of a structure or a
// region, is not one disc at each vertex concerned, if that of a structure has another Euler characteristic -
// but two more, where a handle or a tunnel goes, or, for a cut above 0.1 %, the structure falls into parts,
// as the slice has it, each with a vertex of a contour of its; and two less, for such a cut, where parts of
// it, or of what is not it, that were apart are joined -, if a contour vertex or subsegment leaves the
// surface of its structure, if the cut does not lose half of what is wrong in the patch, or another one gets
// worse by as much, or comes near to 0.1 %, if an interface there is farther than the edit context's
// `spike_mm` from the field's, if a changed cell inside is worse than quality_gate.h allows, or if more cells
// than before, and than 0.3 % of those inside, are above the edit context's first bound. The worst cuts come
// first. Guarantees: all cells positive (checked exactly); no vertex moves but by `improve`. Same result
// every time. Complexity: O(cells) for each cut concerned and each patch repaired, and the shapes of the
// cells of a hundred patches tried in vain at most, and, where planes cross, of 5,000 cells for one cut and
// 20,000 in all. Errors: none; a cancelled run stops. `look`: nothing is wrong but in cells that share a
// vertex with one of these, in any order, such that are gone allowed; null: in any.
PatchRepairStats repair_section_patch(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                      const ImproveCells& improve, const RunContext& context,
                                      const std::vector<std::uint32_t>* look = nullptr);

}  // namespace anatomesh
