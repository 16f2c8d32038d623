// reconcile_contours: slices that cross, drawn apart, are made to agree on their common lines.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/compare/reconcile_stats.h"

namespace anatomesh {

struct ReconcileResult {
    ContourSet kept;
    ReconcileStats stats;
};

// Finds, for all pairs of slices that cross, where their regions begin and end on the common line; ends
// correspond to each other by the order-preserving matching of least cost. The contours are then moved in
// their planes by the field of displacements d that makes corresponding ends equal and has the least integral
// of |d|^2 + smoothing^2 |d'|^2 along all contours together, found by conjugate gradients in a few rounds; an
// interval or gap that only one of two slices has is drawn back across the line when no point has to move
// further than the bound. Then contours that agree get the end itself as a common vertex, and narrow folds
// and spikes that the movement made are cut off (flatten_folds.h). Where slices still differ, all that is
// repeated, as long as they differ by a fifth less, with vertices at just those ends; and once more for what
// a slice lacks altogether though most of those through the line have it: the stretch of its contour nearest
// to it is taken over the line (nearest_arc.h), if none of that has to move further than the bound. What
// is left after that is settled by a small change of one of the two slices (resolve_conflicting_intervals.h).
// Where four planes or more share a line, contours that rise and fall in turn beside it are turned
// (regularize_fans.h). Slivers that are left between structures are closed, and what came to lie on one line
// shares it. Of a structure that a slice leaves undrawn where others show it the slice says nothing
// (undrawn_structures.h).
//
// Requires: a kept contour set. Guarantees: a kept contour set again: contours stay simple, do not cross and
// keep their nesting, by exact predicates; where that needs it a step is shortened. Slices that agree on
// their common line afterwards (difference_after_mm of 0; all that can) have the same points there, bit for
// bit. Where all ends agree within rounding no vertex moves. Parallel slices come back as they are. What
// moved and what is left is said in stats and warnings W-RCN-001..013. Errors: geometry E-RCN-001 slices
// further apart than the bound (names both), E-RCN-002 a shift above it, E-RCN-003 slices that still differ
// when contours have moved as far as they may. The same at any thread count. Complexity: O(n log n +
// crossings) per round. No earlier method is followed.
Result<ReconcileResult> reconcile_contours(ContourSet set, const ReconcileOptions& options,
                                           RunContext& context);

}  // namespace anatomesh
