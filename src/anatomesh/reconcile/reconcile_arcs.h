// Arcs of contours that are taken over a line, because most slices through the line have there what one
// lacks.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/reconcile/move/movement.h"
#include "anatomesh/reconcile/reconcile_state.h"
#include "anatomesh/reconcile/resolve/line_votes.h"

namespace anatomesh {

// Names a comparison: the two slices, the lower first, and the structure.
using ComparisonKey = std::array<std::uint32_t, 3>;

struct ArcOverLine {
    ComparisonKey comparison{};
    TakenOver over;
};

// Which arcs a repetition of the movement takes over lines.
struct ArcsOverLines {
    std::vector<ArcOverLine> taken;         // in this repetition, in the order of its rounds
    std::vector<ComparisonKey> given_up{};  // rising: those in which an earlier repetition failed
    bool falls_back = false;                // some of these are to be drawn back instead
};

// How an interval or gap that one of two slices has alone is resolved by movement.
enum class LoneRepair : std::uint8_t {
    none,
    draw_back,       // its arc comes back across the line
    take_over,       // an arc of the other slice comes over the line: most slices have it
    take_over_first  // no majority, and that arc is much nearer to the line; drawn back where this fails
};

// The repair of the interval or gap that begins at the end `i` of slice a, or of slice b. Where most slices
// through the line say the same, the slice that contradicts them moves. Otherwise that one moves which has
// to move less: a finger does not go because another slice ends tenths of a millimetre before it. O(points of
// the slices' contours).
LoneRepair lone_repair(const ReconcileState& state, const ReconcileScope& scope,
                       const LineComparison& comparison, const LineVotes& votes, bool of_a, std::uint32_t i);

// Returns whether the arcs of a comparison were given up.
bool are_given_up(const ArcsOverLines& arcs, const LineComparison& comparison);

// Pins the arcs of a comparison's slices that have to come over the line, and notes them as taken. An arc
// has to if one slice has an interval that the other one lacks, and lone_repair() says so. An arc stays where a point of it would have to move further than the bound. Returns whether there
// was one. Complexity: O(points of the slices' contours) an interval.
bool pin_arcs_over_line(const ReconcileState& state, const ReconcileScope& scope,
                        const LineComparison& comparison, const LineVotes& votes, const ContourGraph& graph,
                        std::vector<MovementNode>& nodes, ArcsOverLines& arcs);

// Gives contours vertices at the ends and in the middle of the arcs that have to come over a line, and
// compares the slices anew where it gave any. Returns whether any arc has to.
bool split_arcs_over_lines(ReconcileState& state, const ReconcileScope& scope, const ArcsOverLines& arcs,
                           RunContext& context);

// The comparisons of the taken arcs that still differ by more than half as much as before, rising.
std::vector<ComparisonKey> still_differing(std::span<const ArcOverLine> taken,
                                           std::span<const LineComparison> before,
                                           std::span<const LineComparison> after);

// Gives the arcs of these comparisons up. Those that no majority asked for are drawn back in the next
// repetition. `state`: as it was before they were taken.
void give_up(const ReconcileState& state, const ReconcileScope& scope,
             const std::vector<ComparisonKey>& failed, ArcsOverLines& arcs);

// Adds the taken arcs to the statistics: for each slice and structure the farthest stays, in their order.
void note_taken_over(std::span<const ArcOverLine> taken, std::vector<TakenOver>& all);

}  // namespace anatomesh
