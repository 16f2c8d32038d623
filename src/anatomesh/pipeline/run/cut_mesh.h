// The step "cut": cells change region, and then are split, until the surface of every structure is a manifold
// through its contours.
#pragma once

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/pipeline/run/run_state.h"

namespace anatomesh {

// Relabels cells, with new points beside subsegments that were given up for a manifold's sake; recovers the
// segments that the mesh lacks, where the effort has that; splits what is left, and removes what is too small
// to be drawn. `working` receives the mesh, `stats` what was counted, both as far as it came. Requires: cells
// that are refined. Errors: E-CUT-001 of resolve_nonmanifold(); those of ContourSubsegments; cancelled.
Status cut_mesh(const PreparedRun& run, const SampleStats& sample, double max_radius_edge,
                GrowingMesh& growing, WorkingMesh& working, CutStats& stats, RunContext& context);

// Spurious components go (spurious_components.h): as a part of the cut, and again once contours were
// re-routed. `given`: by vertex, one of a contour. O(cells)
SpuriousComponentStats drop_spurious_components(const PreparedRun& run, double size_mm,
                                                std::span<const std::uint8_t> given, WorkingMesh& working,
                                                int threads);

}  // namespace anatomesh
