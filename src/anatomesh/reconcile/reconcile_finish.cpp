#include "anatomesh/reconcile/reconcile_finish.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "anatomesh/contour/walls/merge_coincident.h"
#include "anatomesh/contour/walls/slivers.h"
#include "anatomesh/reconcile/compare/disagreement.h"
#include "anatomesh/reconcile/move/reindex_points.h"
#include "anatomesh/reconcile/regularize/enforce_clearance.h"
#include "anatomesh/reconcile/regularize/regularize_along_axis.h"
#include "anatomesh/reconcile/regularize/regularize_fans.h"
#include "anatomesh/reconcile/resolve/resolve_conflicting_intervals.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

// Where no contour moved by this share of the radius, slices agreed as drawn. [1; 0 to 1; M 2026-11, set not
// recorded]
constexpr double least_moved_share = 0.05;
// Contours are regularized up to this share of the mean distance between vertices from an axis.
// [1; > 0; M 2026-11 69 random sets about an axis]
constexpr double radius_share = 0.3;
// Surfaces that fold more sharply beside an axis are regularized. [degrees; 0 to 180; M 2026-11 69 random
// sets about an axis]
constexpr double sharp_fold_degrees = 70;
// Contours keep this share of the clearance from each other. [1; 0 to 1; M 2026-11 69 random sets about an
// axis]
constexpr double apart_share = 0.5;
// Contours are parted or joined over intervals up to this many mean distances between vertices.
// [distances; > 0; M 2026-11 a heart]
constexpr double parted_share = 2;

// Returns the state with common points put in once more, after contours changed. Returns `before` where
// slices would agree less than `left`. Requires: the state is compared.
ReconcileState with_common_points(ReconcileState state, const ReconcileState& before, double left,
                                  const ReconcileScope& scope, RunContext& context) {
    const ContourSet without = state.set;
    share_points(state);
    carry_over_original(state, without, state.original);
    summarize_movements(state.set, state.original, state.stats);
    compare_slices(state, scope, context);
    return total_difference_mm(state.comparisons) > left ? before : state;
}

ReconcileState with_fans_regularized(ReconcileState state, const FanOptions& options,
                                     const ReconcileScope& scope, RunContext& context) {
    ReconcileState before = state;
    state.stats.fans = regularize_fans(state.set, state.original, options);
    if (state.stats.fans.fans == 0) return state;
    summarize_movements(state.set, state.original, state.stats);
    compare_slices(state, scope, context);
    const bool less = total_difference_mm(state.comparisons) > total_difference_mm(before.comparisons);
    return less ? before : state;
}

ReconcileState with_contours_along_axis_regularized(ReconcileState state, const AlongAxisOptions& options,
                                                    const ReconcileScope& scope, RunContext& context) {
    const ReconcileState before = state;
    AlongAxisBounds most_mm;
    for (const SliceMovement& movement : state.stats.movements) most_mm.push_back(movement.max_mm);
    state.stats.along_axis = regularize_along_axis(state.set, state.original, most_mm, options);
    if (state.stats.along_axis.points == 0) return state;
    compare_slices(state, scope, context);
    return with_common_points(std::move(state), before, total_difference_mm(before.comparisons), scope,
                              context);
}

// Lets `conflate` lead contours through each other's vertices, and gives the figures that it returns to
// `stats`. The change is taken back where slices would agree less, or where a vertex would be further from
// where it was drawn than it may.
template <class Conflate>
ReconcileState conflated(ReconcileState state, ConflationStats ReconcileStats::*stats, Conflate&& conflate,
                         const ReconcileScope& scope, RunContext& context) {
    ReconcileState before = state;
    const ConflationStats done = conflate(state.set);
    if (done.contours_changed == 0) return state;
    const std::optional<ContourSet> same = in_order_of(state.set, before.set);
    if (!same) return before;
    carry_over_original(state, *same, before.original);
    summarize_movements(state.set, state.original, state.stats);
    compare_slices(state, scope, context);
    const double most = std::max(before.stats.max_movement_mm, scope.options.max_disagreement_mm);
    if (total_difference_mm(state.comparisons) > total_difference_mm(before.comparisons) ||
        state.stats.max_movement_mm > most)
        return before;
    state.stats.*stats = done;
    return state;
}

}  // namespace

Result<ReconcileState> resolve_what_is_left(ReconcileState state, const ReconcileScope& scope,
                                            RunContext& context) {
    if (total_difference_mm(state.comparisons) <= line_in_plane_mm) return state;
    const auto compare = [&](const ContourSet& set) { return comparisons_of(set, state, scope, context); };
    const ConflictingIntervalOptions options{scope.clearance_mm, scope.options.max_disagreement_mm,
                                             parted_share * mean_vertex_spacing(state.set)};
    state.stats.resolved = resolve_conflicting_intervals(state.set, state.original, state.comparisons,
                                                         compare, options, context);
    if (state.stats.resolved.empty()) return state;
    compare_slices(state, scope, context);
    const ReconcileState before = state;
    return with_common_points(std::move(state), before, total_difference_mm(before.comparisons), scope,
                              context);
}

Result<ReconcileState> regularize_at_axes(ReconcileState state, const ReconcileScope& scope,
                                          RunContext& context) {
    const FanOptions options{radius_share * mean_vertex_spacing(state.set), sharp_fold_degrees,
                             scope.options.max_disagreement_mm};
    if (state.stats.max_movement_mm < least_moved_share * options.radius_mm) return state;
    state = with_fans_regularized(std::move(state), options, scope, context);
    return with_contours_along_axis_regularized(
        std::move(state), {options.radius_mm, options.least_degrees, options.most_moved_mm}, scope, context);
}

Result<ReconcileState> take_apart(ReconcileState state, const ReconcileScope& scope, RunContext& context) {
    const ReconcileState before = state;
    state.stats.clearance = enforce_clearance(state.set, state.original, apart_share * scope.clearance_mm);
    if (state.stats.clearance.places == 0) return state;
    compare_slices(state, scope, context);
    return with_common_points(std::move(state), before, total_difference_mm(before.comparisons), scope,
                              context);
}

Result<ReconcileState> unite_walls(ReconcileState state, const ReconcileScope& scope, RunContext& context) {
    if (state.stats.max_movement_mm == 0 || state.set.structures.size() < 2) return state;
    state = conflated(
        std::move(state), &ReconcileStats::slivers,
        [&](ContourSet& set) {
            CloseSliversOptions options;
            options.width_mm = scope.options.close_slivers_mm.value_or(options.width_mm);
            return close_slivers(set, options);
        },
        scope, context);
    return conflated(
        std::move(state), &ReconcileStats::shared_lines,
        [&](ContourSet& set) -> ConflationStats {
            MergeCoincidentOptions options;
            options.width_mm = scope.options.same_line_mm.value_or(options.width_mm);
            return merge_coincident(set, options);
        },
        scope, context);
}

Result<ReconcileState> measure_what_is_left(ReconcileState state, const ReconcileScope&, RunContext&) {
    summarize_after(state.comparisons, state.stats);
    return state;
}

}  // namespace anatomesh
