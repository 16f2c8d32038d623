// Reconciling slices that cross, between reading the contours and building the model.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "anatomesh/measure/report.h"
#include "anatomesh/reconcile/reconcile.h"
#include "shared_walls.h"

namespace anatomesh {

struct ReconcileStepOptions {
    ReconcileOptions stage;
    std::string reconcile = "1";     // "0": only measure
    std::vector<std::string> given;  // the options among these that were given
};

// --max-disagreement, --reconcile, --align.
void add_reconcile_options(CLI::App& verb, ReconcileStepOptions& options);

// Reconciles `kept` in place, with walls shared by the widths of `walls` afterwards. The report of its
// crossing slices; without any it is empty and `kept` as it was. Error: usage E-CMD-008 an option was given
// and the slices are parallel, so that none cross.
Result<CrossingReport> reconcile_step(ContourSet& kept, const WallOptions& walls,
                                      const ReconcileStepOptions& options, RunContext& context);

}  // namespace anatomesh
