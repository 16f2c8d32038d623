#include "reconcile_step.h"

#include <fmt/format.h>

#include <utility>

#include "option_values.h"

namespace anatomesh {

void add_reconcile_options(CLI::App& verb, ReconcileStepOptions& options) {
    add_number(verb, "--max-disagreement", options.stage.max_disagreement_mm, 0.001, 1000, "MM",
               fmt::format("Move contours of slices that cross by up to MM, so that they agree (where more "
                           "than two meet in a "
                           "line, with most of them), 0.001 to 1000; slices further apart, in the median of "
                           "their region ends or in what would have to move, are refused; nor do contours "
                           "go further to follow the surface where no edges of it run along them "
                           "(default {})",
                           options.stage.max_disagreement_mm));
    add_choice(verb, "--reconcile", options.reconcile, {"0", "1"},
               "Whether contours of slices that cross are made to agree, and follow the surface where no "
               "edges of it run along them (1, default), or are kept as drawn (0)");
    verb.add_flag("--align", options.stage.align,
                  "First shift every slice in its plane so that it agrees best with those that it crosses");
    for (const char* name : {"--max-disagreement", "--reconcile", "--align"}) {
        verb.get_option(name)->each([&options, name](const std::string&) { options.given.push_back(name); });
    }
}

Result<CrossingReport> reconcile_step(ContourSet& kept, const WallOptions& walls,
                                      const ReconcileStepOptions& options, RunContext& context) {
    if (!options.given.empty() && all_parallel(kept, parallel_tolerance_mm)) {
        const std::string& option = options.given.front();
        return Error{ErrorKind::usage,
                     "E-CMD-008",
                     option + " does not apply: the slices are parallel, so that none cross",
                     {kept.source, "", "", "", ""},
                     "leave out " + option};
    }
    ReconcileOptions stage = options.stage;
    stage.reconcile = options.reconcile == "1";
    stage.same_line_mm = walls.same_line_mm;
    stage.close_slivers_mm = walls.close_slivers_mm;
    ANATOMESH_TRY(ReconcileResult result, reconcile_contours(std::move(kept), stage, context));
    kept = std::move(result.kept);
    const ReconcileStats& stats = result.stats;
    CrossingReport report;
    if (stats.pairs.empty()) return report;
    report.reconciled = stage.reconcile;
    report.ends = stats.ends;
    report.unmatched = stats.unmatched;
    report.median_mm = stats.median_mm;
    report.p95_mm = stats.p95_mm;
    report.max_mm = stats.max_mm;
    report.difference_mm = stats.difference_mm;
    report.difference_after_mm = stats.difference_after_mm;
    report.mean_movement_mm = stats.mean_movement_mm;
    report.max_movement_mm = stats.max_movement_mm;
    report.shared_points = stats.shared_points;
    for (const PairDisagreement& pair : stats.pairs) {
        report.pairs.push_back({kept.slices[pair.slice_a].name, kept.slices[pair.slice_b].name, pair.ends,
                                pair.unmatched, pair.median_mm, pair.p95_mm, pair.max_mm, pair.difference_mm,
                                pair.difference_after_mm});
    }
    for (std::size_t s = 0; s < stats.movements.size(); ++s) {
        const SliceMovement& movement = stats.movements[s];
        report.slices.push_back({kept.slices[s].name,
                                 movement.mean_mm,
                                 movement.max_mm,
                                 {movement.shift.x, movement.shift.y, movement.shift.z}});
    }
    return report;
}

}  // namespace anatomesh
