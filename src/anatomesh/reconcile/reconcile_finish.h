// The steps of reconcile_contours() after contours moved: what movement cannot do, and what it left behind.
#pragma once

#include "anatomesh/reconcile/reconcile_state.h"

namespace anatomesh {

// Each step returns the state that it got where slices would agree less after it.

// Changes one of two slices beside each interval on which they still differ
// (resolve_conflicting_intervals.h).
ReconcileStep resolve_what_is_left;

// Regularizes the contours beside lines of four planes or more: fans at points of such a line
// (regularize_fans.h) and contours along it (regularize_along_axis.h). Where slices agreed as they were drawn
// nothing is regularized: a sharp edge along a plane is then one.
ReconcileStep regularize_at_axes;

// Takes contours apart that movement brought nearly to touch (enforce_clearance.h).
ReconcileStep take_apart;

// Closes the slivers between structures that movement left (slivers.h), and merges what came to lie on one
// line (merge_coincident.h). Nothing is done where no vertex moved.
ReconcileStep unite_walls;

// Fills how much slices differ in the end.
ReconcileStep measure_what_is_left;

}  // namespace anatomesh
