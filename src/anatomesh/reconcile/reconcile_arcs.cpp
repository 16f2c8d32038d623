#include "anatomesh/reconcile/reconcile_arcs.h"

#include <algorithm>
#include <cmath>
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

// Of two arcs, either of which would resolve an interval, the other slice's is taken if its height is less than
// this share of the own one's. [1; 0 to 1; M 2026-11 fingers, slots and slits beside a line]
constexpr double much_nearer = 0.5;
// It is also lower than this share of the bound. A contour that ends farther before the line was meant to end
// there, or at its image's edge. [1; 0 to 1; M 2026-11, the same and a ball in images that end within it]
constexpr double nearly_reaching = 1.0 / 3;

// A vertex of the contour this near to an end of the interval, along the line, comes onto the line there.
// [mm; > 0; D least distance of vertices that split_at_places() puts in]
constexpr double end_reach_mm = 0.1;

// This arc of a slice has to come over the line for the slice to have what the other one has.
struct LackingArc {
    std::uint32_t slice = 0;
    bool for_most = false;     // slices through the line, or for the other one alone
    double low = 0, high = 0;  // the interval, along the line
    std::uint32_t having = 0;  // the other slice
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
    if (are_given_up(arcs, comparison)) return all;
    for (const bool of_a : {true, false}) {
        const auto& ends = of_a ? comparison.endpoints_a : comparison.endpoints_b;
        const std::uint32_t having = of_a ? comparison.a : comparison.b,
                            slice = of_a ? comparison.b : comparison.a;
        for (const std::uint32_t i :
             of_a ? comparison.matching.only_first : comparison.matching.only_second) {
            const double low = ends[i].t, high = ends[i + 1].t;
            const LoneRepair repair = lone_repair(state, scope, comparison, votes, of_a, i);
            if (repair != LoneRepair::take_over && repair != LoneRepair::take_over_first) continue;
            NearestArc arc = nearest_arc(state.set, slice, comparison.structure, comparison.line,
                                         state.set.slices[having].plane, low, high);
            if (!arc.empty() && is_within_bound(state, scope, slice, arc))
                all.push_back({slice, repair == LoneRepair::take_over, low, high, having, std::move(arc)});
        }
    }
    return all;
}

// Pins the arc's vertices at the ends of the interval to come onto the line and not beyond it: both contours
// leave the line at one place then. Between vertices the contour would leave it up to a segment off, and what
// one slice has would move along the line by as much.
void pin_ends(const ContourSet& set, const LackingArc& lacking, const Line& line, const ContourGraph& graph,
              std::vector<MovementNode>& nodes) {
    const Plane &own = set.slices[lacking.slice].plane, &other = set.slices[lacking.having].plane;
    const double sine = length(cross(own.normal, other.normal));
    std::vector<std::uint32_t> points = lacking.arc.points;
    for (const Contour& contour : set.contours_of(set.slices[lacking.slice])) {
        const std::uint32_t first = points.front(), last = points.back();
        if (first < contour.first_point || first >= contour.first_point + contour.point_count) continue;
        points.push_back(point_before(contour, first));
        points.push_back(point_after(contour, last));
        break;
    }
    for (const std::uint32_t k : points) {
        const double t = line.along(set.points[k]);
        if (std::min(std::abs(t - lacking.low), std::abs(t - lacking.high)) > end_reach_mm) continue;
        MovementNode& node = nodes[graph.node_of_point[k]];
        if (node.hold == Hold::anchor) continue;
        const double height = std::abs(other.signed_distance(set.points[k])) / sine;
        node = {Hold::pinned, 0, 0, height * lacking.arc.back};
    }
}

double difference_of(std::span<const LineComparison> all, const ComparisonKey& key) {
    const auto at =
        std::lower_bound(all.begin(), all.end(), key,
                         [](const LineComparison& one, const ComparisonKey& k) { return key_of(one) < k; });
    return at != all.end() && key_of(*at) == key ? at->difference_mm : 0.0;
}

}  // namespace

LoneRepair lone_repair(const ReconcileState& state, const ReconcileScope& scope,
                       const LineComparison& comparison, const LineVotes& votes, bool of_a, std::uint32_t i) {
    const auto& ends = of_a ? comparison.endpoints_a : comparison.endpoints_b;
    const std::uint32_t own = of_a ? comparison.a : comparison.b, other = of_a ? comparison.b : comparison.a;
    const double low = ends[i].t, high = ends[i + 1].t;
    if (votes.most_agree(comparison, own, 0.5 * (low + high))) return LoneRepair::take_over;
    const Arc back = arc_between(state.set, ends[i], ends[i + 1], state.set.slices[own].plane,
                                 state.set.slices[other].plane);
    if (back.points.empty() || back.height_mm > scope.options.max_disagreement_mm) return LoneRepair::none;
    if (votes.most_differ(comparison, own, 0.5 * (low + high))) return LoneRepair::draw_back;
    const NearestArc over = nearest_arc(state.set, other, comparison.structure, comparison.line,
                                        state.set.slices[own].plane, low, high);
    const bool is_nearer = !over.empty() && over.height_mm < much_nearer * back.height_mm &&
                           over.height_mm < nearly_reaching * scope.options.max_disagreement_mm &&
                           is_within_bound(state, scope, other, over);
    return is_nearer ? LoneRepair::take_over_first : LoneRepair::draw_back;
}

bool are_given_up(const ArcsOverLines& arcs, const LineComparison& comparison) {
    return std::binary_search(arcs.given_up.begin(), arcs.given_up.end(), key_of(comparison));
}

bool pin_arcs_over_line(const ReconcileState& state, const ReconcileScope& scope,
                        const LineComparison& comparison, const LineVotes& votes, const ContourGraph& graph,
                        std::vector<MovementNode>& nodes, ArcsOverLines& arcs) {
    bool any = false;
    for (const LackingArc& lacking : lacking_arcs(state, scope, comparison, votes, arcs)) {
        if (lacking.arc.points.empty()) continue;
        pin_arc(lacking.arc, scope.clearance_mm, graph, nodes);
        if (!lacking.for_most) pin_ends(state.set, lacking, comparison.line, graph, nodes);
        arcs.taken.push_back(
            {key_of(comparison),
             {lacking.slice, comparison.structure, lacking.arc.height_mm, lacking.for_most}});
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

void give_up(const ReconcileState& state, const ReconcileScope& scope,
             const std::vector<ComparisonKey>& failed, ArcsOverLines& arcs) {
    const LineVotes votes(state.comparisons);
    for (const LineComparison& comparison : state.comparisons) {
        if (!std::binary_search(failed.begin(), failed.end(), key_of(comparison))) continue;
        for (const bool of_a : {true, false}) {
            for (const std::uint32_t i :
                 of_a ? comparison.matching.only_first : comparison.matching.only_second)
                arcs.falls_back |=
                    lone_repair(state, scope, comparison, votes, of_a, i) == LoneRepair::take_over_first;
        }
    }
    arcs.given_up.insert(arcs.given_up.end(), failed.begin(), failed.end());
    std::sort(arcs.given_up.begin(), arcs.given_up.end());
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
