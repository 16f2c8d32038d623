// build_once: one run of the method, from kept contours to a checked model, one line a stage.
#pragma once

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/pipeline/model/model.h"
#include "anatomesh/pipeline/model/stage_observer.h"
#include "anatomesh/pipeline/retry/run_config.h"
#include "anatomesh/pipeline/retry/run_score.h"
#include "anatomesh/pipeline/run/run_state.h"

namespace anatomesh {

struct BuiltOnce {
    Result<Model> model;
    RunOutcome outcome;
    FieldAndVolumes known;
    double size_mm = 0;  // the edge length aimed at; 0: it did not come so far
    WorkReport work;
};

// `known`: of a run before, or the slices alone. Requires: a kept contour set. Guarantees: the same result every time.
// Errors: those of the steps, E-PIP-002 a broken clause among them (finish_model.h), and cancelled.
BuiltOnce build_once(const ContourSet& contours, const RunConfig& config, RunContext& context,
                     const StageObserver& observer, FieldAndVolumes known);

}  // namespace anatomesh
