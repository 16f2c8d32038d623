// The last step, "certificate": the mesh becomes a model in the caller's coordinates, is measured and judged.
#pragma once

#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/measure/topology/topology_warnings.h"
#include "anatomesh/pipeline/model/model.h"
#include "anatomesh/pipeline/run/improve_run.h"
#include "anatomesh/pipeline/run/run_state.h"

namespace anatomesh {

// Drops the cells outside, gives contour vertices their coordinates as they came, bit for bit, and re-routes
// contours whose segments are no edges of the surface over edges beside them, where the caller allows it.
// Everything of `model` but the report's measured figures and `drawn` is filled. Afterwards `working` has the
// neighbours of the model's cells alone. O(cells)
void finish_model(const PreparedRun& run, const ImproveInput& input, WorkingMesh& working, RoutedRun& routed,
                  Model& model, int threads);

// Fills the report by measure_model(). Requires: a finished model.
void measure_run(const PreparedRun& run, const ContourSet& source, const RunContext& context, Model& model);

// Warns of what was measured (model_warnings.h, topology_warnings.h). Returns where the surface is joined
// otherwise than drawn. Requires: a measured model that keeps clause 3.
TopologyFindings warn_of_run(const PreparedRun& run, const Model& model,
                             const std::vector<std::uint32_t>& neighbors, RunContext& context);

// Errors: E-PIP-002 a clause of the contract is broken; of kind `internal` where that is clause 1, 3 or 5, even if
// others are broken as well.
Status judge_run(const PreparedRun& run, const ModelReport& report, bool size_given);

}  // namespace anatomesh
