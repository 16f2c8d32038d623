// The steps of reconcile_contours() before contours move: shifts, common lines, planes, and what is refused.
#pragma once

#include "anatomesh/reconcile/reconcile_state.h"

namespace anatomesh {

// What reconciling begins with.
struct ReconcileStart {
    ReconcileScope scope;
    ReconcileState state;
};

// Measures how far slices reach and which of them cross, and finds of what slices say nothing, as they were
// drawn. The state has no comparisons yet. `set` and `options`: in working units of so many mm. Complexity: that of compare_planes.
ReconcileStart start_of(ContourSet set, const ReconcileOptions& options, double unit_mm, RunContext& context);

// Shifts every slice rigidly in its plane (align_slices.h) until no shift grows by 0.001 mm, 12 times at
// most, and takes off what all shifts have in common. A shift counts as drawn: bounds are measured from where
// it takes the contours. Errors: geometry E-RCN-002 a shift above the bound.
ReconcileStep align_rigidly;

// Leads contours of several slices that run along their common line through each other's vertices
// (common_lines.h).
ReconcileStep lead_along_lines;

// Turns planes that a file has rounded so that they meet in their axis, and puts points onto their planes
// (snap_planes_to_axis.h).
ReconcileStep snap_planes;

// Compares all slices and fills the figures of how far they are from agreeing.
ReconcileStep measure_disagreement;

// Refuses slices that are too far apart (check_bound). Errors: geometry E-RCN-001.
ReconcileStep refuse_too_far_apart;

}  // namespace anatomesh
