#include "anatomesh/reconcile/reconcile_rounds.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "anatomesh/reconcile/compare/reconcile_warnings.h"
#include "anatomesh/reconcile/move/apply_movement.h"
#include "anatomesh/reconcile/move/movement_nodes.h"

namespace anatomesh {

namespace {

// Contours are moved and cut with the planes again, so often at most. [rounds; >= 1; B]
constexpr int most_rounds = 16;
// After so many rounds in a row that gained little none follows. [rounds; >= 1; B]
constexpr int most_idle_rounds = 6;
// A round that leaves more than this share of the worst distance was idle. [1; 0 to 1; M 2026-11, set not
// recorded]
constexpr double idle_share = 0.9;

// Holds what a round asks of the movement.
struct MovementTask {
    std::vector<MovementNode> nodes;
    std::vector<MovementEdge> edges;
    std::vector<double> usual;  // the groups' positions
    double worst_mm = 0;        // of places from their groups' points
    bool is_done = true;        // nothing is left to move
};

// Pins the arcs of intervals and gaps that only one of the slices has to the other side of the line. Returns
// whether there was one.
bool draw_back(const ReconcileState& state, const ReconcileScope& scope, const LineComparison& comparison,
               const LineVotes& votes, const ContourGraph& graph, const ArcsOverLines* arcs,
               std::vector<MovementNode>& nodes) {
    bool any = false;
    const bool given_up = arcs != nullptr && are_given_up(*arcs, comparison);
    for (const bool of_a : {true, false}) {
        const auto& ends = of_a ? comparison.endpoints_a : comparison.endpoints_b;
        const std::uint32_t own = of_a ? comparison.a : comparison.b,
                            other = of_a ? comparison.b : comparison.a;
        for (const std::uint32_t i :
             of_a ? comparison.matching.only_first : comparison.matching.only_second) {
            const LoneRepair repair = lone_repair(state, scope, comparison, votes, of_a, i);
            if (repair != LoneRepair::draw_back && !(given_up && repair == LoneRepair::take_over_first))
                continue;
            const Arc arc = arc_between(state.set, ends[i], ends[i + 1], state.set.slices[own].plane,
                                        state.set.slices[other].plane);
            if (arc.points.empty() || arc.height_mm > scope.options.max_disagreement_mm) continue;
            any = true;
            pin_arc(arc, scope.clearance_mm, graph, nodes);
        }
    }
    return any;
}

MovementTask movement_task(const ReconcileState& state, const ReconcileScope& scope,
                           const ContourGraph& graph, ArcsOverLines* arcs) {
    const EndpointPlaces ends = place_endpoints(state.set, graph, state.comparisons);
    EndpointGroups groups = group_endpoints(state.set, ends, state.comparisons);
    MovementTask task;
    task.worst_mm = groups.worst_mm;
    task.is_done = groups.worst_mm <= joinable_mm;
    task.nodes = movement_nodes(graph, ends, groups);
    const LineVotes votes(state.comparisons);
    for (const LineComparison& comparison : state.comparisons) {
        if (draw_back(state, scope, comparison, votes, graph, arcs, task.nodes)) task.is_done = false;
        if (arcs != nullptr && pin_arcs_over_line(state, scope, comparison, votes, graph, task.nodes, *arcs))
            task.is_done = false;
    }
    task.edges = movement_edges(state.set, graph, ends);
    task.usual = std::move(groups.position);
    return task;
}

}  // namespace

Status move_in_rounds(ReconcileState& state, const ReconcileScope& scope, ArcsOverLines* arcs,
                      RunContext& context) {
    const ContourGraph graph = make_contour_graph(state.set);
    double best = std::numeric_limits<double>::infinity();
    int idle = 0;
    for (int round = 0; round < most_rounds; ++round, ++state.stats.rounds) {
        if (round > 0) compare_slices(state, scope, context);
        if (context.cancelled()) return cancelled_error();
        const MovementTask task = movement_task(state, scope, graph, arcs);
        if (task.is_done) return Nothing{};
        idle = task.worst_mm < idle_share * best ? 0 : idle + 1;
        // An arc that has yet to come over a line is in no group, so the first worst distance says nothing.
        if (arcs == nullptr || round > 0) best = std::min(best, task.worst_mm);
        if (idle == most_idle_rounds) return Nothing{};
        const std::vector<Vec2> moves =
            solve_movement(task.nodes, task.edges, task.usual, scope.options.smoothing);
        apply_movement(state.set, graph, state.original, moves, scope.options.max_disagreement_mm,
                       context.threads);
    }
    compare_slices(state, scope, context);
    return Nothing{};
}

}  // namespace anatomesh
