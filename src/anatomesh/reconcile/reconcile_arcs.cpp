#include "anatomesh/reconcile/reconcile_arcs.h"

#include <algorithm>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/reconcile/move/movement_nodes.h"
#include "anatomesh/reconcile/move/split_at_endpoints.h"
#include "anatomesh/reconcile/resolve/nearest_arc.h"

namespace anatomesh {

namespace {

// An arc that leaves more than this share of the slices' difference has failed. [1; 0 to 1; M 2026-11, set
// not recorded]
constexpr double failed_share = 0.5;

// This arc of a slice has to come over the line for the slice to have what the other one has.
struct LackingArc {
    std::uint32_t slice = 0;
    NearestArc arc;
};

ComparisonKey key_of(const LineComparison& comparison) {
    return {comparison.a, comparison.b, comparison.structure};
}

// Returns whether no point of the arc comes further from where it was drawn than the bound when it is
// taken over.
bool is_within_bound(const ReconcileState& state, const ReconcileScope& scope, std::uint32_t slice,
                     const NearestArc& arc) {
    const double bound = scope.options.max_disagreement_mm;
    const Plane& plane = state.set.slices[slice].plane;
    for (std::size_t n = 0; n < arc.points.size(); ++n) {
        const std::uint32_t k = arc.points[n];
        const Vec2 way = distance_across(arc.heights_mm[n], arc.height_mm, scope.clearance_mm) * arc.back;
        if (length(state.set.points[k] + way.x * plane.u + way.y * plane.v - state.original.at[k]) > bound)
            return false;
    }
    return distance_across(arc.height_mm, arc.height_mm, scope.clearance_mm) <= bound;
}

std::vector<LackingArc> lacking_arcs(const ReconcileState& state, const ReconcileScope& scope,
                                     const LineComparison& comparison, const LineVotes& votes,
                                     const ArcsOverLines& arcs) {
    std::vector<LackingArc> all;
    if (std::binary_search(arcs.given_up.begin(), arcs.given_up.end(), key_of(comparison))) return all;
    for (const bool of_a : {true, false}) {
        const auto& ends = of_a ? comparison.endpoints_a : comparison.endpoints_b;
        const std::uint32_t having = of_a ? comparison.a : comparison.b,
                            slice = of_a ? comparison.b : comparison.a;
        for (const std::uint32_t i :
             of_a ? comparison.matching.only_first : comparison.matching.only_second) {
            const double low = ends[i].t, high = ends[i + 1].t;
            if (!votes.most_agree(comparison, having, 0.5 * (low + high))) continue;
            NearestArc arc = nearest_arc(state.set, slice, comparison.structure, comparison.line,
                                         state.set.slices[having].plane, low, high);
            if (!arc.empty() && is_within_bound(state, scope, slice, arc))
                all.push_back({slice, std::move(arc)});
        }
    }
    return all;
}

double difference_of(std::span<const LineComparison> all, const ComparisonKey& key) {
    const auto at =
        std::lower_bound(all.begin(), all.end(), key,
                         [](const LineComparison& one, const ComparisonKey& k) { return key_of(one) < k; });
    return at != all.end() && key_of(*at) == key ? at->difference_mm : 0.0;
}

}  // namespace

bool pin_arcs_over_line(const ReconcileState& state, const ReconcileScope& scope,
                        const LineComparison& comparison, const LineVotes& votes, const ContourGraph& graph,
                        std::vector<MovementNode>& nodes, ArcsOverLines& arcs) {
    bool any = false;
    for (const LackingArc& lacking : lacking_arcs(state, scope, comparison, votes, arcs)) {
        if (lacking.arc.points.empty()) continue;
        pin_arc(lacking.arc, scope.clearance_mm, graph, nodes);
        arcs.taken.push_back(
            {key_of(comparison), {lacking.slice, comparison.structure, lacking.arc.height_mm}});
        any = true;
    }
    return any;
}

bool split_arcs_over_lines(ReconcileState& state, const ReconcileScope& scope, const ArcsOverLines& arcs,
                           RunContext& context) {
    const LineVotes votes(state.comparisons);
    std::vector<IntervalEndpoint> places;
    bool any = false;
    for (const LineComparison& comparison : state.comparisons) {
        for (const LackingArc& lacking : lacking_arcs(state, scope, comparison, votes, arcs)) {
            any = true;
            places.insert(places.end(), lacking.arc.places.begin(), lacking.arc.places.end());
        }
    }
    if (!places.empty()) {
        split_at_places(state.set, places);
        compare_slices(state, scope, context);
    }
    return any;
}

std::vector<ComparisonKey> still_differing(std::span<const ArcOverLine> taken,
                                           std::span<const LineComparison> before,
                                           std::span<const LineComparison> after) {
    std::vector<ComparisonKey> failed;
    for (const ArcOverLine& arc : taken) {
        if (difference_of(after, arc.comparison) > failed_share * difference_of(before, arc.comparison))
            failed.push_back(arc.comparison);
    }
    sort_distinct(failed);
    return failed;
}

void note_taken_over(std::span<const ArcOverLine> taken, std::vector<TakenOver>& all) {
    for (const ArcOverLine& arc : taken) all.push_back(arc.over);
    const auto key = [](const TakenOver& t) { return std::pair(t.slice, t.structure); };
    std::sort(all.begin(), all.end(), [&](const TakenOver& p, const TakenOver& q) {
        return key(p) != key(q) ? key(p) < key(q) : p.farthest_mm > q.farthest_mm;
    });
    all.erase(std::unique(all.begin(), all.end(),
                          [&](const TakenOver& p, const TakenOver& q) { return key(p) == key(q); }),
              all.end());
}

}  // namespace anatomesh
