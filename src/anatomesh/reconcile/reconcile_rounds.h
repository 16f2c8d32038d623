// move_in_rounds: contours move in their planes, round after round, until crossing slices agree.
#pragma once

#include "anatomesh/reconcile/reconcile_arcs.h"
#include "anatomesh/reconcile/reconcile_state.h"

namespace anatomesh {

// Each round solves for the smoothest small movement and applies it. The movement brings each group of
// corresponding endpoints to one point, and arcs that one slice has alone to the other side of the line.
// Moved contours meet the line elsewhere than linear theory says, so the next round measures again.
//
// An arc is not drawn back where most slices through the line contradict the other slice, nor where one of
// the other slice is much nearer to the line (lone_repair). With `arcs`, those that most slices have and one
// lacks are taken over lines as well, and these nearer ones, and noted there. The rounds end
// when nothing is left to move, when the worst distance has not fallen by a tenth for 6 rounds, or after
// 16 rounds.
//
// Requires: a compared state with the original positions of its points. Guarantees: those of
// apply_movement; the state is compared. Errors: cancelled. Complexity: that of compare_planes and of
// solve_movement, for each round.
Status move_in_rounds(ReconcileState& state, const ReconcileScope& scope, ArcsOverLines* arcs,
                      RunContext& context);

}  // namespace anatomesh
