#include "anatomesh/reconcile/reconcile.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <string>
#include <utility>

#include "anatomesh/reconcile/compare/reconcile_warnings.h"
#include "anatomesh/reconcile/reconcile_finish.h"
#include "anatomesh/reconcile/reconcile_move.h"
#include "anatomesh/reconcile/reconcile_prepare.h"
#include "anatomesh/reconcile/working_unit.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"
#include "anatomesh/slices/arrangement/slices_beside_paths.h"

namespace anatomesh {

namespace {

struct NamedStep {
    const char* name;  // as progress is reported
    ReconcileStep* run;
    bool ReconcileOptions::*asked_for_by;  // nullptr: done in any case
};

// These steps are done where slices cross, in this order.
constexpr std::array steps{
    NamedStep{"align slices", align_rigidly, &ReconcileOptions::align},
    NamedStep{"lead contours along common lines", lead_along_lines, &ReconcileOptions::reconcile},
    NamedStep{"snap planes to their axis", snap_planes, &ReconcileOptions::reconcile},
    NamedStep{"measure the disagreement", measure_disagreement, nullptr},
    NamedStep{"refuse what is too far apart", refuse_too_far_apart, &ReconcileOptions::reconcile},
    NamedStep{"move contours and join them", move_and_join, &ReconcileOptions::reconcile},
    NamedStep{"repeat with more vertices", repeat_with_more_vertices, &ReconcileOptions::reconcile},
    NamedStep{"take arcs over lines", take_arcs_over_lines, &ReconcileOptions::reconcile},
    NamedStep{"refuse what moved too far", refuse_what_moved_too_far, &ReconcileOptions::reconcile},
    NamedStep{"resolve what is left", resolve_what_is_left, &ReconcileOptions::reconcile},
    NamedStep{"regularize at axes", regularize_at_axes, &ReconcileOptions::reconcile},
    NamedStep{"take contours apart", take_apart, &ReconcileOptions::reconcile},
    NamedStep{"unite walls", unite_walls, &ReconcileOptions::reconcile},
    NamedStep{"measure what is left", measure_what_is_left, nullptr},
};

// Contours begin at their smallest point and stand in order, as in every kept set.
void put_in_order(ContourSet& set) {
    for (const Slice& slice : set.slices) {
        const auto first = set.contours.begin() + slice.first_contour, last = first + slice.contour_count;
        for (auto contour = first; contour != last; ++contour) {
            const auto begin = set.points.begin() + contour->first_point, end = begin + contour->point_count;
            std::rotate(begin, std::min_element(begin, end, LexicographicLess{}), end);
        }
        std::stable_sort(first, last, [&](const Contour& p, const Contour& q) {
            if (p.structure != q.structure) return p.structure < q.structure;
            return lexicographic_less(set.points[p.first_point], set.points[q.first_point]);
        });
    }
}

}  // namespace

Result<ReconcileResult> reconcile_contours(ContourSet set, const ReconcileOptions& options,
                                           RunContext& context) {
    assert(options.max_disagreement_mm > 0 && options.smoothing > 0 && options.margin_mm >= 0);
    // Slices along paths say nothing of what their planes cross elsewhere, so none contradicts another one.
    const SliceArrangement arrangement = arrangement_of(set);
    if (arrangement.is_along_paths()) {
        ReconcileStats stats;
        stats.movements.resize(set.slices.size());
        return ReconcileResult{std::move(set), std::move(stats)};
    }
    // A refusal names slices that contradict each other; told before it is which one keeps all from being along paths.
    warn_about_slices_beside_paths(set, arrangement, context);
    const double unit_mm = working_unit_mm(set);
    auto [scope, state] =
        start_of(in_units(std::move(set), unit_mm), in_units(options, unit_mm), unit_mm, context);
    const bool do_cross = !state.pairs.empty();
    for (std::size_t n = 0; n < steps.size() && do_cross; ++n) {
        if (context.cancelled()) return cancelled_error();
        if (steps[n].asked_for_by != nullptr && !(options.*steps[n].asked_for_by)) continue;
        context.report(std::string("reconcile: ") + steps[n].name,
                       static_cast<double>(n) / static_cast<double>(steps.size()));
        ANATOMESH_TRY(state, steps[n].run(std::move(state), scope, context));
    }
    if (context.cancelled()) return cancelled_error();
    ReconcileResult result{in_mm(std::move(state.set), unit_mm), in_mm(std::move(state.stats), unit_mm)};
    for (UndrawnStructure& undrawn : scope.undrawn) undrawn.shown_mm *= unit_mm;
    for (IsolatedSlice& isolated : scope.isolated) isolated.gap_mm *= unit_mm;
    warn_of_reconciling(result.kept, options, result.stats, scope.undrawn, scope.isolated, unit_mm, context);
    put_in_order(result.kept);
    return result;
}

}  // namespace anatomesh
