#include "anatomesh/measure/crossing_report.h"

namespace anatomesh {

CrossingReport crossing_report(const ContourSet& kept, const ReconcileStats& stats, bool reconciled) {
    CrossingReport report;
    if (stats.pairs.empty()) return report;
    report.reconciled = reconciled;
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
