#include "anatomesh/reconcile/working_unit.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

// Planes count as no nearer to each other, in distances of vertices. [1; 0 to 1; D a movement is as long as a contour
// shows]
constexpr double nearest_planes = 0.5;
// Nor as further. [1; > 1; D a few planes across a structure say nothing of how finely it was drawn]
constexpr double farthest_planes = 16;
// Drawn spacings from here to four times as much need no other unit: lengths of reconciling were measured on them.
// [mm; > 0; M 2026-12 fetal brain 1.8, heart 3.4, ball in a ball 1.5, random sets 2.6 to 4.9]
constexpr double least_usual_spacing = 1.25;
// Nor up to here. [mm; > least_usual_spacing; D four times as much]
constexpr double most_usual_spacing = 4 * least_usual_spacing;

void scale(ContourSet& set, double factor) {
    for (Vec3& point : set.points) point = factor * point;
    for (Slice& slice : set.slices) slice.plane.origin = factor * slice.plane.origin;
    for (LeftOutSlice& slice : set.left_out) slice.plane.origin = factor * slice.plane.origin;
    set.pixel_mm *= factor;
    set.slice_thickness_mm *= factor;
}

void scale(ConflationStats& stats, double factor) {
    stats.widest_mm *= factor;
    stats.area_mm2 *= factor * factor;
}

}  // namespace

double drawn_spacing(const ContourSet& set) {
    if (set.points.empty()) return 0;
    const double vertices = mean_vertex_spacing(set), planes = plane_spacings(set, plane_patches(set)).median;
    return std::sqrt(vertices * std::clamp(planes, nearest_planes * vertices, farthest_planes * vertices));
}

double working_unit_mm(const ContourSet& set) {
    const double spacing = drawn_spacing(set);
    if (spacing > 0 && spacing < least_usual_spacing)
        return std::exp2(std::floor(std::log2(spacing / least_usual_spacing)));
    return spacing > most_usual_spacing ? std::exp2(std::ceil(std::log2(spacing / most_usual_spacing))) : 1;
}

ContourSet in_units(ContourSet set, double unit_mm) {
    scale(set, 1 / unit_mm);
    return set;
}

ReconcileOptions in_units(ReconcileOptions options, double unit_mm) {
    options.max_disagreement_mm /= unit_mm;
    options.margin_mm /= unit_mm;
    if (options.same_line_mm) *options.same_line_mm /= unit_mm;
    if (options.close_slivers_mm) *options.close_slivers_mm /= unit_mm;
    return options;
}

ReconcileOptions with_widths(ReconcileOptions options, const WallOptions& walls) {
    const WallOptions usual;
    if (walls.same_line_mm != usual.same_line_mm) options.same_line_mm = walls.same_line_mm;
    if (walls.close_slivers_mm != usual.close_slivers_mm) options.close_slivers_mm = walls.close_slivers_mm;
    return options;
}

ContourSet in_mm(ContourSet set, double unit_mm) {
    scale(set, unit_mm);
    return set;
}

ReconcileStats in_mm(ReconcileStats stats, double unit_mm) {
    const auto scale_all = [&](auto&... lengths) { ((lengths *= unit_mm), ...); };
    scale_all(stats.median_mm, stats.p95_mm, stats.max_mm, stats.difference_mm, stats.difference_after_mm,
              stats.mean_movement_mm, stats.max_movement_mm, stats.folds.highest_mm, stats.fans.highest_mm,
              stats.along_axis.farthest_mm, stats.clearance.farthest_mm);
    for (PairDisagreement& pair : stats.pairs)
        scale_all(pair.median_mm, pair.p95_mm, pair.max_mm, pair.difference_mm, pair.difference_after_mm);
    for (SliceMovement& movement : stats.movements) {
        scale_all(movement.mean_mm, movement.max_mm);
        movement.shift = unit_mm * movement.shift;
    }
    for (TakenOver& arc : stats.taken_over) scale_all(arc.farthest_mm);
    for (ResolvedInterval& interval : stats.resolved) scale_all(interval.length_mm, interval.farthest_mm);
    scale(stats.slivers, unit_mm);
    scale(stats.shared_lines, unit_mm);
    return stats;
}

}  // namespace anatomesh
