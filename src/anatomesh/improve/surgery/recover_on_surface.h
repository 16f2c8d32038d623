// recover_on_surface: subsegments that run beside their structure's surface come to lie on it.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/core/quality_gate.h"

namespace anatomesh {

struct SurfaceRecoveryStats {
    std::uint64_t found = 0, recovered = 0;  // subsegments
    std::vector<std::uint32_t> changed;      // cells that were made or reshaped, some of which may be gone
};

// A subsegment lies beside its surface if it is an edge of the mesh with cells of one side of its structure
// alone round it. Then what is drawn is a fin or a slit thinner than the cells. Subsegments one after the
// other, from a vertex of the surface to the next, are a chain. For each chain:
// 1. Membranes of facets are sought that bind the chain to edges of the surface (spanning_membranes.h):
//    those of the least area, dearer where the field has the side that the chain is on.
// 2. The neighbourhood of a membrane is relabelled (relabel_membrane_neighborhood.h). Where it parts the
//    cells of its region at a vertex, those of one part are relabelled near that vertex too.
// 3. `improve` works on the shapes, and the change stays or is undone (membrane_surgery.h).
//
// A change stays only if all of these hold:
// - Surfaces of structures and regions are one disc at each vertex concerned, and those of structures keep
//   their Euler characteristic. Regions that two structures make along a common wall may come in any number
//   of parts.
// - No contour vertex or subsegment leaves the surface of its structure, and sections do not get worse.
// - Interfaces there are within the edit context's `spike_mm` of the field's.
// - No changed cell inside has an angle whose sine is below `least_sine`, or a ratio above the edit
//   context's last bound. Where contours limit it (drawn.constraint_limited), the bounds of quality_gate.h
//   hold instead.
// - Where cells were parted, the cells above the first bound grow by no more than the share `most_more` of
//   those inside. Changes at no such price are tried first, and cheap ones before dear ones.
//
// Recovered subsegments are fixed and no longer kept (edit_context.h); `improve` may put vertices on them.
// Guarantees: all cells positive (checked exactly); no vertex moves but by `improve`. Same result every time.
// Complexity: O(cells + subsegments), and the shapes of the cells of a hundred membranes tried in vain at
// most: ms to seconds. Errors: none.
SurfaceRecoveryStats recover_on_surface(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                        double most_more, const ImproveCells& improve);

}  // namespace anatomesh
