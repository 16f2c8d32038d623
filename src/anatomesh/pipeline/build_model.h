// build_model: from kept contours to a checked tetrahedral model, by as many runs as it takes.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/pipeline/model/model.h"
#include "anatomesh/pipeline/model/stage_observer.h"

namespace anatomesh {

// Requires: a kept contour set. Guarantees: the clauses of the certificate that are marked kept, checked on
// the result itself; a broken clause is an Error of kind internal or geometry and no model. With a default
// size a model that fails for being too coarse, or one of a thin structure with holes torn into it, is built
// again finer, as often as retry/retry_policy.h allows, with a warning (W-PIP-001); one of planes that cross also
// slightly finer, also where its surface is joined otherwise than drawn (retry_policy.h). A surface with
// handles that the contours do not show is warned of (W-PIP-004).
Result<Model> build_model(const ContourSet& contours, const ModelOptions& options, RunContext& context,
                          const StageObserver& observer = {});

}  // namespace anatomesh
