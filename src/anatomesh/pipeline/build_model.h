// build_model: from kept contours to a checked tetrahedral model, by as many runs as it takes.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/pipeline/model/model.h"
#include "anatomesh/pipeline/model/stage_observer.h"

namespace anatomesh {

// Requires: a kept contour set. Guarantees: the clauses of the certificate that are marked kept, checked on
// the result itself; a broken clause is an Error of kind internal or geometry and no model. The method is run
// again as docs/stages/11b-retries.md says; W-PIP-001 tells of it. The best result is returned. A surface with
// handles that the contours do not show is warned of (W-PIP-004).
Result<Model> build_model(const ContourSet& contours, const ModelOptions& options, RunContext& context,
                          const StageObserver& observer = {});

}  // namespace anatomesh
