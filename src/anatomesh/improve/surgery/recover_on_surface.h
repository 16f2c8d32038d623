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

// A subsegment that is an edge of the mesh, but with cells of one side of its structure alone round it, lies
// where what is drawn is a fin or a slit thinner than the cells. A membrane of facets is sought that such
// subsegments, one after the other from a vertex of the surface to the next, bound together with edges of the
// surface: that of the least area, more where the field has the side that the subsegments are on. The
// membrane is thickened: the edges that lead off it are cut, and what lies between the cuts goes to the other
// side, a regular neighbourhood of the membrane (Rourke and Sanderson, Introduction to Piecewise-Linear
// Topology, 1972, chapter 3) but for the cells that have nothing of it but subsegments on its rim - these are
// on its surface - and those of other regions than the chain's, which other structures' surfaces need. Where
// it parts the cells of its region at a vertex - one of the surface, on its rim -, those of one part go to
// the other side near that vertex too. Then `improve` works on the shapes. All of it is taken back if a
// surface, of a structure or a region, is not one disc at each vertex concerned, if that of a structure has
// not the same Euler characteristic (regions that two structures make along a common wall may come in any
// number of parts), if a contour vertex or subsegment leaves the surface of its structure, if cuts by slices
// get worse, if an interface there is farther than the edit context's `spike_mm` from the field's, or if a
// cell changed inside has an angle whose sine is below `least_sine` or a ratio above the edit context's last
// bound - where contours limit it (drawn.constraint_limited), as they force it to, those of quality_gate.h -;
// where cells were parted, also if those above its first bound become more by over `most_more` of the cells
// inside: ways at no such price are tried first, and cheap ones before dear ones. Subsegments that were
// recovered are fixed and kept no more (edit_context.h); `improve` may put vertices on them. Guarantees: all
// cells positive (checked exactly); no vertex moves but by `improve`. Same result every time. Complexity:
// O(cells + subsegments), and the shapes of the cells of a hundred membranes tried in vain at most: ms to
// seconds. Errors: none.
SurfaceRecoveryStats recover_on_surface(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                        double most_more, const ImproveCells& improve);

}  // namespace anatomesh
