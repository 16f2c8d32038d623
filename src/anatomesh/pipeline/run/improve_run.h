// The step "improve": shapes, sections and volumes of the mesh, by local operations.
#pragma once

#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/pipeline/run/run_state.h"

namespace anatomesh {

// What does not change while the mesh is improved.
struct ImproveInput {
    const ContourSet& source;  // as given
    const ModelOptions& options;
    const SampleStats& sample;
    const GrowingMesh& growing;  // whose first vertices are those of the sample
};

// Improves the mesh in five passes: vertices onto the interface, smoothing, dihedral angles with sections and
// segments, smoothing again, balance of volumes. Meanwhile the field's volumes are found, if `run` does not
// have them. `routed` receives contours that were re-routed, those alone that are sound. Vertices of
// contours, on segments and of the frame stay where they are. Errors: those of field_volumes(); cancelled.
Result<ImprovedStats> improve_run(PreparedRun& run, const ImproveInput& input, WorkingMesh& working,
                                  RoutedRun& routed, RunContext& context);

// A contour segment leaves its place by at most `sizes`, and no more than the caller allows. mm
double most_reroute_mm(const ModelOptions& options, double sizes, double size_mm);

// The volumes of the field, by structure. mm3
std::vector<double> volumes_by_field(const std::vector<StructureVolume>& volumes);

}  // namespace anatomesh
