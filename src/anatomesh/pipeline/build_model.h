// build_model: from kept contours to a checked tetrahedral model, by as many runs as it takes.
#pragma once

#include <functional>
#include <string>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/pipeline/model/model.h"

namespace anatomesh {

// Called with the mesh after each stage that has one ("cull", "refine", "cut", "improve", "certificate", in
// this order; again from the start on a further attempt): for looking and dumping. The last round is that of
// the model that is returned; where another one was tried after it, it is built once more for that.
using StageObserver = std::function<void(const std::string& stage, const TetMesh& mesh)>;

// Requires: a kept contour set. Guarantees: the clauses of the certificate that are marked kept, checked on
// the result itself; a broken clause is an Error of kind internal or geometry and no model. With a default
// size a model that fails for being too coarse, or one of a thin structure with holes torn into it, is built
// again finer, as often as retry/retry_policy.h allows, with a warning (W-PIP-001); one of planes that cross also
// slightly finer, also where its surface is joined otherwise than drawn (retry_policy.h). A surface with
// handles that the contours do not show is warned of (W-PIP-004).
Result<Model> build_model(const ContourSet& contours, const ModelOptions& options, RunContext& context,
                          const StageObserver& observer = {});

}  // namespace anatomesh
