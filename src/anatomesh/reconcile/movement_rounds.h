// move_in_rounds: contours move in their planes, round after round, until crossing slices agree.
#pragma once

#include "anatomesh/reconcile/arcs_over_lines.h"
#include "anatomesh/reconcile/reconcile_state.h"

namespace anatomesh {

// Each round solves for the smoothest small movement that brings the groups of corresponding ends to one
// point each, and arcs that one slice alone has to the other side of the line, and applies it; sections with
// moved contours lie elsewhere than linear theory has them, so the next round measures again. An arc is not
// drawn back where it is the other slice that most of those through the line contradict. With `arcs`, those
// that most slices have and one lacks are taken over lines as well, and noted there. It ends when nothing is
// left to move, when the worst distance has not fallen by a tenth for 6 rounds, or after 16 rounds.
//
// Requires: a compared state, with the original positions of its points; a slice's contours hold still within
// its plane. Guarantees: those of apply_movement; the state is compared. Errors: cancelled. Complexity: that
// of compare_planes and of solve_movement, for each round.
Status move_in_rounds(ReconcileState& state, const ReconcileScope& scope, ArcsOverLines* arcs,
                      RunContext& context);

}  // namespace anatomesh
