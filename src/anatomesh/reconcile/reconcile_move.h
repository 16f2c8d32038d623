// The steps of reconcile_contours() in which contours move until crossing slices agree.
#pragma once

#include "anatomesh/reconcile/reconcile_state.h"

namespace anatomesh {

// Moves contours in rounds (reconcile_rounds.h) and puts common points in where slices agree then. Folds
// and spikes that the movement made are cut off, unless slices would agree less without them.
ReconcileStep move_and_join;

// Repeats that with vertices at just the places where slices still differ, which a movement can take to where
// they belong. A repetition is kept if slices differ by a fifth less after it; at most 4 are.
ReconcileStep repeat_with_more_vertices;

// Repeats it with what a slice lacks altogether, though most slices have it, or though that is the least
// movement, taken over the line (reconcile_arcs.h). A repetition is kept if, besides, all arcs came there; the arcs that did not are given
// up, and the others taken again. What came over is repeated with more vertices once more.
ReconcileStep take_arcs_over_lines;

// Refuses what differs although contours moved as far as they may (check_what_is_left). Errors: geometry
// E-RCN-003.
ReconcileStep refuse_what_moved_too_far;

}  // namespace anatomesh
