// remove_spurious_handles: small handles of a structure's surface that no contour shows are removed.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/core/quality_gate.h"
#include "anatomesh/mesh/check/spurious_handles.h"

namespace anatomesh {

struct HandleRemovalStats {
    std::uint64_t found = 0, removed = 0;  // handles
    std::vector<std::uint32_t> changed;    // cells that were made or reshaped, some of which may be gone
};

// Where planes cross, a surface may have a handle as small as the cells between them: a hole through a wall,
// or a bridge over a gap (spurious_handles.h). For each such handle:
// 1. Membranes of facets are sought among its vertices, on either side of the surface, whose rim lies on the
//    surface and does not part it: the least in area, dearer where the field has the side that they are on.
// 2. The neighbourhood of a membrane is relabelled (relabel_membrane_neighborhood.h), which fills the hole
//    or cuts the bridge.
// 3. `improve` works on the shapes, and the change stays or is undone (membrane_surgery.h).
//
// A change stays only if all of these hold:
// - Surfaces of structures and regions are one disc at each vertex concerned.
// - The structure's surface has one handle less in the same number of shells, and others are as they were.
// - No contour vertex or subsegment leaves the surface of its structure, and sections do not get worse.
// - Interfaces there are within the edit context's `spike_mm` of the field's, and changed cells inside are
//   as good as quality_gate.h demands.
// - No more cells than before, or than 0.3 % of those inside, are above the edit context's first bound.
//
// `drawn.routable`: of all contours. Guarantees: all cells positive (checked exactly); no vertex moves but by
// `improve`. Same result every time. Complexity: as small_handles() and O(cells) for each handle removed,
// and the shapes of the cells of 60 membranes tried in vain at most. Errors: none; a cancelled run stops.
// Requires: reach_mm > 0; surfaces of structures that are closed manifolds.
HandleRemovalStats remove_spurious_handles(EditContext& edit, const DrawnSlices& drawn, double reach_mm,
                                           double least_sine, const ImproveCells& improve,
                                           const RunContext& context);

}  // namespace anatomesh
