#include "anatomesh/reconcile/reconcile_state.h"

#include "anatomesh/reconcile/move/shared_points.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

// A vertex that went to a common point is found again within this distance.
// [mm; > 0; M 2026-11 fetal brain and variants of it]
constexpr double carried_over_mm = 0.1;

std::vector<LineComparison> compared(const ContourSet& set, const std::vector<PlanePatch>& patches,
                                     const ReconcileState& state, const ReconcileScope& scope,
                                     RunContext& context) {
    std::vector<LineComparison> comparisons =
        compare_planes(set, patches, state.pairs, scope.margin_mm, context);
    std::erase_if(comparisons, [&](const LineComparison& c) {
        return is_undrawn(scope.undrawn, c.a, c.structure) || is_undrawn(scope.undrawn, c.b, c.structure);
    });
    return comparisons;
}

}  // namespace

void compare_slices(ReconcileState& state, const ReconcileScope& scope, RunContext& context) {
    const std::vector<PlanePatch> patches = plane_patches(state.set);
    state.pairs = crossing_pairs(patches, scope.margin_mm);
    state.comparisons = compared(state.set, patches, state, scope, context);
}

std::vector<LineComparison> comparisons_of(const ContourSet& set, const ReconcileState& state,
                                           const ReconcileScope& scope, RunContext& context) {
    return compared(set, plane_patches(set), state, scope, context);
}

void carry_over_original(ReconcileState& state, const ContourSet& before, const OriginalPositions& drawn) {
    state.original = carry_over(before, drawn, state.set, carried_over_mm);
}

void share_points(ReconcileState& state) {
    std::vector<bool> is_moved(state.set.points.size());
    for (std::size_t k = 0; k < is_moved.size(); ++k)
        is_moved[k] = state.set.points[k] != state.original.at[k];
    state.stats.shared_points = insert_shared_points(state.set, state.comparisons, is_moved).points;
}

}  // namespace anatomesh
