#include "anatomesh/reconcile/reconcile_move.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "anatomesh/reconcile/compare/contradictions.h"
#include "anatomesh/reconcile/compare/disagreement.h"
#include "anatomesh/reconcile/move/split_at_endpoints.h"
#include "anatomesh/reconcile/reconcile_arcs.h"
#include "anatomesh/reconcile/reconcile_rounds.h"
#include "anatomesh/reconcile/regularize/flatten_folds.h"

namespace anatomesh {

namespace {

// Slices that still differ get vertices there and are moved again, so often at most. [repetitions; >= 0; B]
constexpr int most_repetitions = 4;
// A repetition is kept if slices differ by this share less after it. [1; 0 to 1; M 2026-11 fetal brain]
constexpr double least_repetition_gain = 0.2;
// Ends of a fold are so many bounds apart at most, along the contour. [bounds; > 0; M 2026-11 fetal brain]
constexpr double longest_fold_bounds = 4;

// Cuts off folds and spikes. Where slices do not agree on their common line, cutting a spike off may move
// an endpoint there. Slices that would be further apart than without any cut keep their spikes.
FoldStats flatten(ReconcileState& state, const ReconcileScope& scope, const std::vector<MovedPoint>& moved,
                  RunContext& context) {
    const ContourSet with_folds = state.set;
    FoldOptions options{longest_fold_bounds * scope.options.max_disagreement_mm,
                        std::vector<bool>(state.set.slices.size(), true)};
    FoldStats folds = flatten_folds(state.set, moved, options);
    compare_slices(state, scope, context);
    const std::vector<PairDisagreement> least = disagreements(state.comparisons);
    options.keeps_spikes.assign(state.set.slices.size(), false);
    for (bool risen = true; risen;) {
        state.set = with_folds;
        folds = flatten_folds(state.set, moved, options);
        compare_slices(state, scope, context);
        risen = false;
        for (const PairDisagreement& now : disagreements(state.comparisons)) {
            const auto was = std::lower_bound(least.begin(), least.end(), now, is_pair_before);
            const bool same = was != least.end() && !is_pair_before(now, *was);
            if (now.difference_mm <= (same ? was->difference_mm : 0)) continue;
            for (const std::uint32_t slice : {now.slice_a, now.slice_b}) {
                risen = risen || !options.keeps_spikes[slice];
                options.keeps_spikes[slice] = true;
            }
        }
    }
    return folds;
}

void add(const FoldStats& folds, FoldStats& total) {
    total.folds += folds.folds;
    total.spikes += folds.spikes;
    total.vertices += folds.vertices;
    total.highest_mm = std::max(total.highest_mm, folds.highest_mm);
}

// Puts common points in where slices agree now, and then cuts folds off.
void join(ReconcileState& state, const ReconcileScope& scope, RunContext& context) {
    const ContourSet before = state.set;
    std::vector<MovedPoint> moved;
    for (std::size_t k = 0; k < before.points.size(); ++k) {
        if (state.original.is_drawn[k]) moved.push_back({before.points[k], state.original.at[k]});
    }
    share_points(state);
    add(flatten(state, scope, moved, context), state.stats.folds);
    carry_over_original(state, before, state.original);
}

Status move_measure_join(ReconcileState& state, const ReconcileScope& scope, ArcsOverLines* arcs,
                         RunContext& context) {
    ANATOMESH_CHECK_STATUS(move_in_rounds(state, scope, arcs, context));
    summarize_movements(state.set, state.original, state.stats);
    join(state, scope, context);
    return Nothing{};
}

// Repeats the movement as long as slices differ less by it, with arcs taken over lines where `over` says so.
Result<ReconcileState> repeat(ReconcileState state, const ReconcileScope& scope, bool over,
                              RunContext& context) {
    ArcsOverLines arcs;
    for (int n = 0; n < most_repetitions; ++n) {
        const double left = total_difference_mm(state.comparisons);
        if (left <= line_in_plane_mm) break;
        ReconcileState before = state;
        arcs.taken.clear();
        if (over && !split_arcs_over_lines(state, scope, arcs, context) && !arcs.falls_back) break;
        split_at_endpoints(state.set, state.comparisons);
        carry_over_original(state, before.set, before.original);
        compare_slices(state, scope, context);
        ANATOMESH_CHECK_STATUS(move_measure_join(state, scope, over ? &arcs : nullptr, context));
        const std::vector<ComparisonKey> failed =
            still_differing(arcs.taken, before.comparisons, state.comparisons);
        if (failed.empty() && total_difference_mm(state.comparisons) <= (1 - least_repetition_gain) * left) {
            note_taken_over(arcs.taken, state.stats.taken_over);
            continue;
        }
        state = std::move(before);
        if (failed.empty()) break;
        give_up(state, scope, failed, arcs);
    }
    return state;
}

}  // namespace

Result<ReconcileState> move_and_join(ReconcileState state, const ReconcileScope& scope, RunContext& context) {
    ANATOMESH_CHECK_STATUS(move_measure_join(state, scope, nullptr, context));
    return state;
}

Result<ReconcileState> repeat_with_more_vertices(ReconcileState state, const ReconcileScope& scope,
                                                 RunContext& context) {
    return repeat(std::move(state), scope, false, context);
}

Result<ReconcileState> take_arcs_over_lines(ReconcileState state, const ReconcileScope& scope,
                                            RunContext& context) {
    ANATOMESH_TRY(state, repeat(std::move(state), scope, true, context));
    if (state.stats.taken_over.empty()) return state;
    return repeat(std::move(state), scope, false, context);
}

Result<ReconcileState> refuse_what_moved_too_far(ReconcileState state, const ReconcileScope& scope,
                                                 RunContext&) {
    ANATOMESH_CHECK_STATUS(
        check_what_is_left(state.set, state.original, state.comparisons, scope.options, scope.unit_mm));
    return state;
}

}  // namespace anatomesh
