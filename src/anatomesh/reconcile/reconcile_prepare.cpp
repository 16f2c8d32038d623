#include "anatomesh/reconcile/reconcile_prepare.h"

#include <algorithm>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/reconcile/compare/contradictions.h"
#include "anatomesh/reconcile/compare/disagreement.h"
#include "anatomesh/reconcile/compare/reconcile_warnings.h"
#include "anatomesh/reconcile/move/align_slices.h"
#include "anatomesh/reconcile/move/common_lines.h"
#include "anatomesh/reconcile/move/movement_nodes.h"
#include "anatomesh/reconcile/move/snap_planes_to_axis.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

// Shifts are found again, so often at most, because they change which ends match. [rounds; >= 1; B]
constexpr int most_align_rounds = 12;

// Shifts the contours of all slices; returns the length of the longest shift.
double shift_slices(ContourSet& set, const std::vector<Vec2>& shifts) {
    for (const Contour& contour : set.contours) {
        const Plane& plane = set.slices[contour.slice].plane;
        const Vec3 shift = shifts[contour.slice].x * plane.u + shifts[contour.slice].y * plane.v;
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k)
            set.points[k] += shift;
    }
    double longest = 0;
    for (const Vec2& shift : shifts) longest = std::max(longest, length(shift));
    return longest;
}

// What a file rounds, in working units, is so much of what it rounds in mm: as many mm, however large the contours are.
// Of small contours that would be a large share, so that it is as many units there.
double rounding_share(const ReconcileScope& scope) {
    return 1 / std::max(1.0, scope.unit_mm);
}

void add(const std::vector<Vec2>& shifts, std::vector<Vec2>& total) {
    for (std::size_t s = 0; s < shifts.size(); ++s) total[s] = total[s] + shifts[s];
}

}  // namespace

ReconcileStart start_of(ContourSet set, const ReconcileOptions& options, double unit_mm,
                        RunContext& context) {
    ReconcileScope scope;
    scope.unit_mm = unit_mm;
    const std::vector<PlanePatch> patches = plane_patches(set);
    scope.options = options;
    scope.clearance_mm = std::max(least_clearance_mm, clearance_share * mean_vertex_spacing(set));
    scope.margin_mm = options.margin_mm != 0 ? options.margin_mm : plane_spacings(set, patches).median;
    ReconcileState state;
    state.pairs = crossing_pairs(patches, scope.margin_mm);
    const std::vector<LineComparison> all =
        compare_planes(set, patches, state.pairs, scope.margin_mm, context);
    scope.undrawn = find_undrawn_structures(set, all, scope.margin_mm);
    scope.isolated = find_isolated_slices(set, patches, all, context);
    state.stats.movements.resize(set.slices.size());
    state.original = original_positions(set);
    state.set = std::move(set);
    return {std::move(scope), std::move(state)};
}

Result<ReconcileState> align_rigidly(ReconcileState state, const ReconcileScope& scope, RunContext& context) {
    const double bound = scope.options.max_disagreement_mm;
    std::vector<Vec2> total(state.set.slices.size());
    for (int round = 0; round < most_align_rounds; ++round) {
        compare_slices(state, scope, context);
        if (context.cancelled()) return cancelled_error();
        const std::vector<Vec2> shifts = estimate_shifts(state.set, state.comparisons, total);
        add(shifts, total);
        if (shift_slices(state.set, shifts) < align_precision_mm) break;
    }
    const Vec3 common = common_translation(state.set, total);
    if (length(common) > 0) {
        std::vector<Vec2> back;
        for (const Slice& slice : state.set.slices)
            back.push_back({-dot(common, slice.plane.u), -dot(common, slice.plane.v)});
        add(back, total);
        shift_slices(state.set, back);
    }
    for (std::uint32_t s = 0; s < total.size(); ++s) {
        const Plane& plane = state.set.slices[s].plane;
        state.stats.movements[s].shift = total[s].x * plane.u + total[s].y * plane.v;
        if (length(total[s]) > bound) {
            return Error{ErrorKind::geometry, "E-RCN-002",
                         "the slice agrees with the slices that it crosses only after a shift of more than " +
                             brief(scope.unit_mm * bound) + " mm",
                         place_of_slice(state.set, s, scope.unit_mm * length(total[s])),
                         "leave the slice out with --without, or allow more with --max-disagreement"};
        }
    }
    state.original = original_positions(state.set);
    return state;
}

Result<ReconcileState> lead_along_lines(ReconcileState state, const ReconcileScope& scope, RunContext&) {
    const ContourSet before = state.set;
    CommonLineOptions options;
    options.width_mm *= rounding_share(scope);
    const CommonLineStats led = lead_along_common_lines(state.set, state.pairs, options);
    if (led.led_through + led.moved > 0)
        state.original = carry_over(before, state.original, state.set, options.width_mm);
    return state;
}

Result<ReconcileState> snap_planes(ReconcileState state, const ReconcileScope& scope, RunContext&) {
    snap_planes_to_axis(state.set, rounding_share(scope));
    return state;
}

Result<ReconcileState> measure_disagreement(ReconcileState state, const ReconcileScope& scope,
                                            RunContext& context) {
    compare_slices(state, scope, context);
    state.stats.pairs = disagreements(state.comparisons);
    summarize(state.comparisons, state.stats);
    return state;
}

Result<ReconcileState> refuse_too_far_apart(ReconcileState state, const ReconcileScope& scope, RunContext&) {
    ANATOMESH_CHECK_STATUS(check_bound(state.set, state.comparisons, scope.options, scope.unit_mm));
    return state;
}

}  // namespace anatomesh
