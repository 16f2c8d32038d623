// reconcile_contours: slices that were drawn apart are made to agree on the lines in which they cross.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/compare/reconcile_stats.h"

namespace anatomesh {

struct ReconcileResult {
    ContourSet kept;
    ReconcileStats stats;
};

// Makes slices agree where their planes cross, in the steps of the table in reconcile.cpp. On the common
// line of two slices the region of a structure is a union of intervals; the endpoints of both are matched
// in order, at least cost.
//
// Contours then move in their planes by displacements d that bring matched endpoints together. Of these, d
// has the least integral of |d|^2 + smoothing^2 |d'|^2 along all contours. An interval or gap that one of two
// slices has alone is drawn back across the line. Contours that agree get the endpoint itself as a common
// vertex, and folds and spikes that the movement made are cut off (flatten_folds.h).
//
// Where slices still differ, contours get vertices at just those endpoints and move again, as long as they
// differ by a fifth less. Then contours are taken over a line where most slices through it have what one
// lacks (nearest_arc.h). What is left is resolved by a small change of one of two slices
// (resolve_conflicting_intervals.h).
//
// Beside a line of four planes or more, contours that rise and fall in turn are regularized
// (regularize_fans.h). Slivers between structures are closed, and what came to lie on one line shares it.
// A slice says nothing of a structure that it leaves undrawn where others show it (undrawn_structures.h).
//
// Requires: a kept contour set. Guarantees: a kept contour set, by exact predicates. Slices that agree
// afterwards (difference_after_mm of 0) have the same points on their common line, bit for bit. Where all
// endpoints agree within rounding no vertex moves, except for those that all but lie at such an endpoint
// (shared_points.h), and parallel slices and slices along
// paths come back as they are. No point
// comes further than the bound from where it was drawn. The result is the same at any number of threads.
// What moved and what is left is in the statistics and in warnings W-RCN-001..013.
//
// Errors: geometry E-RCN-001 two slices are further apart than the bound; E-RCN-002 a shift is above it;
// E-RCN-003 slices still differ when contours have moved as far as they may. Complexity: O(n log n +
// crossings) a round. No earlier method is followed.
Result<ReconcileResult> reconcile_contours(ContourSet set, const ReconcileOptions& options,
                                           RunContext& context);

}  // namespace anatomesh
