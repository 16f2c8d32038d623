#include "anatomesh/contour/overlay/combine.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <set>

#include "anatomesh/contour/overlay/arrangement.h"
#include "anatomesh/contour/overlay/boundary_loops.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

bool is_inside(const RingTurns& turns) {
    return turns.turns % 2 != 0;
}

// Reads areas, relations and levels off an arrangement.
class Reader {
  public:
    Reader(const Arrangement& graph, std::span<const Ring> rings, CombineRule rule, double share)
        : graph_(graph), rings_(rings), rule_(rule), share_(share) {
        result_.fates.resize(rings.size());
    }

    Combined run() {
        measure();
        look_at_cycles();
        relate();
        find_levels();
        measure_groups();
        trace();
        return std::move(result_);
    }

  private:
    using Pair = std::pair<std::uint32_t, std::uint32_t>;

    // Twice the signed area between an edge and a common origin: summed over a closed boundary, its area.
    double area_under(const Arrangement::Edge& edge) const {
        const Vec2 origin = graph_.at[0];
        return 0.5 * cross(graph_.at[edge.a] - origin, graph_.at[edge.b] - origin);
    }

    void measure() {
        std::vector<double> positive(rings_.size(), 0), negative(rings_.size(), 0);
        for (const Arrangement::Edge& edge : graph_.edges) {
            const double area = area_under(edge);
            for (const auto& [id, sign] : {std::pair{edge.left, 1.0}, std::pair{edge.right, -1.0}}) {
                const Winding& winding = graph_.windings[id];
                for (std::size_t i = 0; i < winding.size(); ++i) {
                    const RingTurns& turns = winding[i];
                    if (turns.turns != 1) positive[turns.ring] += sign * area;
                    if (turns.turns != -1) negative[turns.ring] += sign * area;
                    if (!is_inside(turns)) continue;
                    result_.fates[turns.ring].area_mm2 += sign * area;
                    for (std::size_t j = i + 1; j < winding.size(); ++j) {
                        if (is_inside(winding[j]))
                            result_.common_mm2[{turns.ring, winding[j].ring}] += sign * area;
                    }
                }
            }
        }
        for (std::size_t r = 0; r < rings_.size(); ++r) {
            result_.fates[r].ambiguous_area_mm2 = std::max(0.0, std::min(positive[r], negative[r]));
        }
    }

    void look_at_cycles() {
        std::map<Pair, std::uint32_t> ring_of_edge;
        for (std::uint32_t r = 0; r < graph_.cycles.size(); ++r) {
            const std::vector<std::uint32_t>& cycle = graph_.cycles[r];
            std::vector<std::uint32_t> sorted = cycle;
            std::sort(sorted.begin(), sorted.end());
            RingFate& fate = result_.fates[r];
            fate.touches_itself = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
            for (std::size_t i = 0; i < cycle.size(); ++i) {
                const Pair edge = std::minmax(cycle[i], cycle[i + 1 < cycle.size() ? i + 1 : 0]);
                const auto [entry, is_new] = ring_of_edge.try_emplace(edge, r);
                if (is_new) continue;
                if (entry->second == r) {
                    fate.retraces_itself = true;
                } else {
                    fate.shares_edge = result_.fates[entry->second].shares_edge = true;
                }
            }
        }
    }

    std::uint32_t group_of(std::uint32_t ring) {
        while (group_[ring] != ring) ring = group_[ring] = group_[group_[ring]];
        return ring;
    }

    bool join(std::uint32_t p, std::uint32_t q) {
        p = group_of(p), q = group_of(q);
        if (p == q) return false;
        group_[std::max(p, q)] = std::min(p, q);
        return true;
    }

    // Which of two rings with a common part lies in the other, if any.
    void relate() {
        group_.resize(rings_.size());
        std::iota(group_.begin(), group_.end(), 0u);
        inside_.resize(rings_.size());
        for (const auto& [pair, area] : result_.common_mm2) {
            std::uint32_t small = pair.second, large = pair.first;
            if (result_.fates[small].area_mm2 > result_.fates[large].area_mm2) std::swap(small, large);
            const double small_area = result_.fates[small].area_mm2,
                         large_area = result_.fates[large].area_mm2;
            if (area <= area_rounding_share * small_area) continue;
            const double beyond = small_area - area;
            const bool within = beyond <= area_rounding_share * small_area;
            if (within || (beyond <= share_ * small_area && small_area < (1 - share_) * large_area)) {
                inside_[small].push_back(large);
                if (!within) result_.fates[small].protruding_area_mm2 += beyond;
            } else {
                result_.overlaps.push_back({pair.first, pair.second, area});
                join(small, large);
            }
        }
    }

    // A group lies in another one when all its rings do; where only some do, the groups are one.
    void find_levels() {
        std::vector<std::set<std::uint32_t>> around;  // per group: the groups it lies in
        for (bool joined = rule_ == CombineRule::nest_and_unite; joined;) {
            joined = false;
            std::map<Pair, std::uint32_t> rings_inside;  // (inner group, outer group): how many rings
            std::vector<std::uint32_t> size(rings_.size(), 0);
            for (std::uint32_t r = 0; r < rings_.size(); ++r) {
                ++size[group_of(r)];
                std::set<std::uint32_t> outer;
                for (std::uint32_t large : inside_[r]) outer.insert(group_of(large));
                for (std::uint32_t group : outer) {
                    if (group != group_of(r)) ++rings_inside[{group_of(r), group}];
                }
            }
            around.assign(rings_.size(), {});
            for (const auto& [groups, count] : rings_inside) {
                if (count < size[groups.first]) {
                    joined |= join(groups.first, groups.second);
                } else {
                    around[groups.first].insert(groups.second);
                }
            }
        }
        for (std::uint32_t r = 0; r < rings_.size(); ++r) {
            RingFate& fate = result_.fates[r];
            fate.group = group_of(r);
            if (rule_ == CombineRule::nest_and_unite)
                fate.level = static_cast<std::uint32_t>(around[fate.group].size());
            for (std::uint32_t large : inside_[r]) {
                if (group_of(large) == fate.group) continue;
                if (fate.parent < 0 || result_.fates[large].area_mm2 <
                                           result_.fates[static_cast<std::size_t>(fate.parent)].area_mm2) {
                    fate.parent = static_cast<std::int32_t>(large);
                }
            }
        }
    }

    void measure_groups() {
        std::vector<double>& overlap = result_.overlap_of_group_mm2;
        overlap.assign(rings_.size(), 0);
        for (std::size_t r = 0; r < rings_.size(); ++r)
            overlap[result_.fates[r].group] += result_.fates[r].area_mm2;
        std::set<std::uint32_t> present;
        for (const Arrangement::Edge& edge : graph_.edges) {
            const double area = area_under(edge);
            for (const auto& [id, sign] : {std::pair{edge.left, 1.0}, std::pair{edge.right, -1.0}}) {
                present.clear();
                for (const RingTurns& turns : graph_.windings[id]) {
                    if (is_inside(turns)) present.insert(result_.fates[turns.ring].group);
                }
                for (std::uint32_t group : present) overlap[group] -= sign * area;
            }
        }
        for (double& area : overlap) area = std::max(0.0, area);
    }

    // Whether a face belongs to the region.
    bool belongs(const Winding& winding) const {
        std::int64_t level = -1;
        std::size_t count = 0;
        for (const RingTurns& turns : winding) {
            if (!is_inside(turns)) continue;
            ++count;
            level = std::max<std::int64_t>(level, result_.fates[turns.ring].level);
        }
        if (rule_ == CombineRule::exclusive_or) return count % 2 == 1;
        return level >= 0 && level % 2 == 0;
    }

    // Directed boundary edges with the region on their left, and the smallest ring that has each.
    struct Boundary {
        std::uint32_t from, to, ring;
    };

    void trace() {
        std::vector<char> inside;
        for (const Winding& winding : graph_.windings) inside.push_back(belongs(winding));
        for (const Arrangement::Edge& edge : graph_.edges) {
            if (inside[edge.left] == inside[edge.right]) continue;
            const std::uint32_t ring =
                first_difference(graph_.windings[edge.left], graph_.windings[edge.right]);
            boundary_.push_back(inside[edge.left] ? Boundary{edge.a, edge.b, ring}
                                                  : Boundary{edge.b, edge.a, ring});
        }
        std::sort(boundary_.begin(), boundary_.end(), [&](const Boundary& p, const Boundary& q) {
            if (p.from != q.from) return lexicographic_less(graph_.at[p.from], graph_.at[q.from]);
            return lexicographic_less(graph_.at[p.to], graph_.at[q.to]);
        });
        std::vector<BoundaryEdge> edges;
        for (const Boundary& edge : boundary_) edges.push_back({edge.from, edge.to});
        for (const std::vector<std::uint32_t>& loop : boundary_loops(graph_.at, edges)) emit(loop);
        count_kept_points();
    }

    std::uint32_t first_difference(const Winding& p, const Winding& q) const {
        for (std::size_t i = 0; i < std::min(p.size(), q.size()); ++i) {
            if (!(p[i] == q[i])) return std::min(p[i].ring, q[i].ring);
        }
        return p.size() > q.size() ? p[q.size()].ring : q[p.size()].ring;
    }

    void emit(std::span<const std::uint32_t> loop) {
        Ring ring;
        ring.source = boundary_[loop[0]].ring;
        bool from_one_ring = true;
        for (std::uint32_t edge : loop) {
            from_one_ring = from_one_ring && boundary_[edge].ring == boundary_[loop[0]].ring;
            ring.source = std::min(ring.source, boundary_[edge].ring);
            ring.push_back(graph_.at[boundary_[edge].from], graph_.points[boundary_[edge].from]);
        }
        const double area = std::abs(signed_area(ring.at));
        const bool whole = from_one_ring && loop.size() == graph_.cycles[ring.source].size();
        if (!whole && 2 * area <= sliver_width_mm * perimeter(ring.at)) {
            result_.sliver_area_mm2 += area;
            return;
        }
        for (std::uint32_t edge : loop) on_result_.insert(boundary_[edge].from);
        result_.rings.push_back(std::move(ring));
    }

    void count_kept_points() {
        for (std::size_t r = 0; r < rings_.size(); ++r) {
            // The vertices of a ring are those of its cycle that it had before it was cut.
            std::size_t next = 0;
            for (std::uint32_t vertex : graph_.cycles[r]) {
                if (next == rings_[r].size() || !(graph_.at[vertex] == rings_[r].at[next])) continue;
                ++next;
                result_.fates[r].points_kept += on_result_.count(vertex) > 0;
            }
        }
    }

    const Arrangement& graph_;
    std::span<const Ring> rings_;
    const CombineRule rule_;
    const double share_;
    Combined result_;
    std::vector<std::uint32_t> group_;                // union-find
    std::vector<std::vector<std::uint32_t>> inside_;  // per ring: the rings it lies in
    std::vector<Boundary> boundary_;
    std::set<std::uint32_t> on_result_;  // vertices
};

}  // namespace

std::optional<Combined> combine_rings(std::span<const Ring> rings, const Plane& plane, CombineRule rule,
                                      double share, std::size_t most_edges) {
    const std::optional<Arrangement> graph = arrange(rings, plane, most_edges);
    if (!graph) return std::nullopt;
    Combined combined = Reader(*graph, rings, rule, share).run();
    for (Ring& ring : combined.rings) ring.source = rings[ring.source].source;
    return combined;
}

}  // namespace anatomesh
