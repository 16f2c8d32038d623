// The main pass of the step "improve": dihedral angles, sections, segments and handles.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/pipeline/run/improve_run.h"

namespace anatomesh {

// improve_mesh() with what is drawn, as the run's effort has it. `fixed` grows by the vertices that are
// made. Contour segments that are edges of the surface stay edges of it.
MeshImprovementStats improve_angles(const PreparedRun& run, const ImproveInput& input, WorkingMesh& working,
                                    std::vector<std::uint8_t>& fixed, RunContext& context);

// What of the slices improvement keeps: nothing where the effort repairs no sections.
SliceWeights slices_to_keep(const PreparedRun& run);

}  // namespace anatomesh
