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
// or a bridge over a gap (spurious_handles.h). Among its vertices a membrane of facets is sought, on either
// side of the surface, whose rim lies on the surface and does not part it: the least in area, more where the
// field has the side that it is on. The membrane's neighbourhood is relabelled
// (relabel_membrane_neighborhood.h): its regular neighbourhood goes to the other side, which fills the hole
// or cuts the bridge. Then `improve` works on the shapes. All of it is taken back if a surface, of a
// structure or a region, is not one disc at each vertex concerned, if that of the structure has not one
// handle less in the same number of shells and others are not as they were, if a contour vertex or subsegment
// leaves the surface of its structure, if cuts by slices get worse, if an interface there is farther than the
// edit context's `spike_mm` from the field's, if a changed cell inside is worse than quality_gate.h allows,
// or if more cells than before, and than 0.3 % of those inside, are above the edit context's first bound.
// `drawn.routable`: of all contours. Guarantees: all cells positive (checked exactly); no vertex moves but
// by `improve`. Same result every time. Complexity: as small_handles() and O(cells) for each handle removed,
// and the shapes of the cells of 60 membranes tried in vain at most. Errors: none; a cancelled run stops.
// Requires: reach_mm > 0; surfaces of structures that are closed manifolds.
HandleRemovalStats remove_spurious_handles(EditContext& edit, const DrawnSlices& drawn, double reach_mm,
                                           double least_sine, const ImproveCells& improve,
                                           const RunContext& context);

}  // namespace anatomesh
