#include "anatomesh/improve/reroute/snap_round_segments.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <queue>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/improve/reroute/contour_loop.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/model/surface_graph.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_seen = 20'000;  // vertices, for a way: beside a segment there are a few
constexpr double least_distance = 1e-3;    // in most_mm: of ways as near, the shorter one
constexpr double backwards_price = 100;
constexpr int most_repairs = 200;  // ways at fault in a slice that are replaced; what is more goes

// How a missed segment is re-routed, in turn: with so many segments before and after it; over what edges.
enum class Over : std::uint8_t {
    all,
    onwards,  // that lead on along it: such a way crosses itself nowhere
    clear     // that cross no contour of the slice, and backwards at a high price: it may cross itself
};
struct Routing {
    std::uint32_t before, after;
    Over over;
};
constexpr int rounds = 3;  // over the missed segments of a slice
constexpr std::array<Routing, 9> routings{{{0, 0, Over::all},
                                           {0, 0, Over::onwards},
                                           {0, 0, Over::clear},
                                           {0, 1, Over::clear},
                                           {1, 0, Over::clear},
                                           {1, 1, Over::clear},
                                           {0, 2, Over::clear},
                                           {2, 0, Over::clear},
                                           {2, 2, Over::clear}}};

// In the place of some segments of a ring, one after the other.
struct Way {
    std::uint32_t first = 0, count = 1;
    std::uint32_t missed = 0;            // for whose sake it was sought
    std::uint32_t replaced = 0;          // segments that are missed
    std::vector<std::uint32_t> between;  // vertices, without the ends
    double farthest_mm = 0;
};

// A contour as it is now.
struct Ring {
    std::vector<std::uint32_t> vertices;
    std::vector<Way> ways;  // by first segment, rising

    std::uint32_t size() const { return static_cast<std::uint32_t>(vertices.size()); }
    // How far segment n is after the first one of a way.
    std::uint32_t steps(const Way& way, std::uint32_t n) const { return (n + size() - way.first) % size(); }
    bool is_rerouted(std::uint32_t n) const {
        return std::any_of(ways.begin(), ways.end(),
                           [&](const Way& way) { return steps(way, n) < way.count; });
    }
};

// All vertices, and for each segment between them the index of the way that it is of, or the number of ways.
struct RingWithWays {
    std::vector<std::uint32_t> vertices;
    std::vector<std::size_t> way_of;
};

RingWithWays with_ways(const Ring& ring) {
    RingWithWays whole;
    const auto add = [&](std::uint32_t v, std::size_t way) {
        whole.vertices.push_back(v);
        whole.way_of.push_back(way);
    };
    // From a way on, the last one may end beyond the ring's own end.
    std::size_t next = 0;
    const std::uint32_t start = ring.ways.empty() ? 0 : ring.ways.front().first;
    for (std::uint32_t k = 0; k < ring.size();) {
        const std::uint32_t n = (start + k) % ring.size();
        if (next == ring.ways.size() || ring.ways[next].first != n) {
            add(ring.vertices[n], ring.ways.size());
            ++k;
            continue;
        }
        add(ring.vertices[n], next);
        for (const std::uint32_t v : ring.ways[next].between) add(v, next);
        k += ring.ways[next].count;
        ++next;
    }
    return whole;
}

// Leads the contours of one structure in one slice.
class SliceSnapRounding {
  public:
    // `rings`: of all contours of the slice.
    SliceSnapRounding(std::span<const Vec3> points, const SurfaceGraph& graph, const ContourSet& set,
                      const Slice& slice, std::uint32_t structure, std::span<Ring> rings, double most_mm)
        : points_(points), graph_(graph), set_(set), slice_(slice), rings_(rings), most_mm_(most_mm) {
        const std::span<const Contour> contours = set.contours_of(slice);
        for (std::uint32_t n = 0; n < contours.size(); ++n) {
            if (contours[n].structure == structure) own_.push_back(n);
        }
    }

    void run() {
        // What such contours do to others cannot be known.
        const auto lost_a_vertex = [](const Ring& ring) {
            return std::find(ring.vertices.begin(), ring.vertices.end(), no_cell) != ring.vertices.end();
        };
        if (std::any_of(rings_.begin(), rings_.end(), lost_a_vertex) || !lacks_any()) return;
        for (const std::uint32_t r : own_)
            taken_.insert(rings_[r].vertices.begin(), rings_[r].vertices.end());
        look_at_others();
        // What stood in the way of others may be re-routed otherwise after a round.
        for (int round = 0; round < rounds && lead_missed(); ++round) {
            while (const std::optional<RingAndWay> worst = worst_at_fault()) {
                const Way before = take_out(worst->ring, worst->way);
                if (++repairs_ <= most_repairs) lead_otherwise(worst->ring, before);
            }
            // Ways that are sound stay.
            tried_.clear();
            for (const std::uint32_t r : own_) {
                for (const Way& way : rings_[r].ways) tried_[{r, way.missed}] = routings.size();
            }
        }
    }

  private:
    struct Reached {
        double distance = 0;  // from what is drawn
        double price = HUGE_VAL;
        std::uint32_t from = no_cell;
        bool is_done = false;
    };
    struct RingAndWay {
        std::uint32_t ring;
        std::size_t way;
    };

    bool is_missed(std::uint32_t r, std::uint32_t n) const {
        const Ring& ring = rings_[r];
        return !graph_.chain(ring.vertices[n], ring.vertices[(n + 1) % ring.size()]);
    }

    bool lacks_any() const {
        return std::any_of(own_.begin(), own_.end(), [&](std::uint32_t r) {
            for (std::uint32_t n = 0; n < rings_[r].size(); ++n) {
                if (is_missed(r, n)) return true;
            }
            return false;
        });
    }

    // Whether any was re-routed.
    bool lead_missed() {
        bool any = false;
        for (const std::uint32_t r : own_) {
            for (std::uint32_t n = 0; n < rings_[r].size(); ++n) {
                if (rings_[r].is_rerouted(n) || !is_missed(r, n)) continue;
                route(r, n);
                any |= rings_[r].is_rerouted(n);
            }
        }
        return any;
    }

    // In the first manner that was not tried in vain.
    void route(std::uint32_t r, std::uint32_t n) {
        for (std::size_t& tried = tried_[{r, n}]; tried < routings.size() && !rings_[r].is_rerouted(n);) {
            if (route(r, n, routings[tried])) return;
            ++tried;
        }
    }

    // Whether it has a way now. Those that are in its place give way to it.
    bool route(std::uint32_t r, std::uint32_t n, const Routing& routing) {
        Ring& ring = rings_[r];
        Way way{(n + ring.size() - routing.before) % ring.size(),
                1 + routing.before + routing.after,
                n,
                0,
                {},
                0};
        if (way.count + 2 > ring.size()) return false;
        stretch_.clear();
        for (std::uint32_t k = 0; k <= way.count; ++k)
            stretch_.push_back(ring.vertices[(way.first + k) % ring.size()]);
        stretch_places_ = places(stretch_);
        for (std::uint32_t k = 0; k < way.count; ++k)
            way.replaced += !graph_.chain(stretch_[k], stretch_[k + 1]);
        const auto is_inside = [&](const Way& other) {
            return ring.steps(way, other.first) + other.count <= way.count;
        };
        for (std::uint32_t k = 0; k < way.count; ++k) {
            const std::uint32_t covered = (way.first + k) % ring.size();
            for (const Way& other : ring.ways) {
                if (ring.steps(other, covered) < other.count && !is_inside(other)) return false;
            }
        }
        if (way.count > 1 || !take_twin(way)) {
            if (routing.over == Over::clear) find_beside(r, way);
            if (!find(routing.over)) return false;
            for (std::uint32_t v = reached_.at(stretch_.back()).from; v != stretch_.front();
                 v = reached_.at(v).from)
                way.between.push_back(v);
            std::reverse(way.between.begin(), way.between.end());
        }
        way.farthest_mm = farthest(way);
        if (way.farthest_mm > most_mm_) return false;
        for (std::size_t k = ring.ways.size(); k-- > 0;) {
            if (is_inside(ring.ways[k])) take_out(r, k);
        }
        taken_.insert(way.between.begin(), way.between.end());
        const auto place = std::find_if(ring.ways.begin(), ring.ways.end(),
                                        [&](const Way& other) { return other.first > way.first; });
        ring.ways.insert(place, std::move(way));
        return true;
    }

    // What other structures have in the slice: their vertices, their segments as drawn, and ways of theirs in
    // the place of one segment.
    void look_at_others() {
        for (std::uint32_t n = 0; n < rings_.size(); ++n) {
            if (std::find(own_.begin(), own_.end(), n) != own_.end()) continue;
            const Ring& ring = rings_[n];
            const std::uint32_t structure = set_.contours_of(slice_)[n].structure;
            const RingWithWays whole = with_ways(ring);
            of_others_.insert(whole.vertices.begin(), whole.vertices.end());
            for (std::uint32_t k = 0; k < ring.size(); ++k)
                sharing_[ends(ring.vertices[k], ring.vertices[(k + 1) % ring.size()])].push_back(structure);
            for (const Way& way : ring.ways) {
                const std::uint32_t a = ring.vertices[way.first];
                if (way.count == 1)
                    twins_[ends(a, ring.vertices[(way.first + 1) % ring.size()])] = {a, way.between};
            }
            PlaneRing& flat = others_.emplace_back(PlaneRing{structure, {}});
            for (const std::uint32_t v : whole.vertices) flat.at.push_back(at(v));
        }
    }

    static std::array<std::uint32_t, 2> ends(std::uint32_t a, std::uint32_t b) {
        return {std::min(a, b), std::max(a, b)};
    }

    // A segment of a common wall goes the way of the other structure's, if that is edges of this one too.
    bool take_twin(Way& way) const {
        const std::uint32_t a = stretch_.front(), b = stretch_.back();
        const auto twin = twins_.find(ends(a, b));
        if (twin == twins_.end()) return false;
        std::vector<std::uint32_t> between = twin->second.between;
        if (twin->second.from != a) std::reverse(between.begin(), between.end());
        std::uint32_t before = a;
        for (std::size_t k = 0; k <= between.size(); ++k) {
            const std::uint32_t v = k < between.size() ? between[k] : b;
            const std::span<const std::uint32_t> beside = graph_.neighbors(before);
            if (std::find(beside.begin(), beside.end(), v) == beside.end()) return false;
            before = v;
        }
        way.between = std::move(between);
        return true;
    }

    // The larger of the distances of its vertices from stretch_, and of those from it.
    double farthest(const Way& way) const {
        std::vector<std::uint32_t> row{stretch_.front()};
        row.insert(row.end(), way.between.begin(), way.between.end());
        row.push_back(stretch_.back());
        return distance_of_rows(stretch_places_, places(row));
    }

    std::vector<Vec3> places(const std::vector<std::uint32_t>& vertices) const {
        std::vector<Vec3> all;
        for (const std::uint32_t v : vertices) all.push_back(points_[v]);
        return all;
    }

    // Whether a way runs inside another structure; not of one that shares a segment in its place, which goes
    // the same way if it can.
    bool is_in_another(const Ring& ring, const Way& way) const {
        if (!way.between.empty() && of_others_.contains(way.between.front())) return false;  // a common wall
        std::vector<std::uint32_t> sharing;
        for (std::uint32_t k = 0; k < way.count; ++k) {
            const std::uint32_t n = (way.first + k) % ring.size();
            const auto found = sharing_.find(ends(ring.vertices[n], ring.vertices[(n + 1) % ring.size()]));
            if (found != sharing_.end())
                sharing.insert(sharing.end(), found->second.begin(), found->second.end());
        }
        const Vec2 a = at(ring.vertices[way.first]),
                   b = at(ring.vertices[(way.first + way.count) % ring.size()]);
        const Vec2 p = way.between.empty() ? 0.5 * (a + b) : at(way.between.front());
        std::map<std::uint32_t, bool> inside;  // by structure
        for (const PlaneRing& other : others_) {
            if (std::find(sharing.begin(), sharing.end(), other.structure) != sharing.end()) continue;
            for (std::size_t n = 0; n < other.at.size(); ++n) {
                const Vec2 s = other.at[n], t = other.at[(n + 1) % other.at.size()];
                if ((s.y > p.y) != (t.y > p.y) && (orient2d(s, t, p) > 0) == (t.y > s.y))
                    inside[other.structure] = !inside[other.structure];
            }
        }
        return std::any_of(inside.begin(), inside.end(), [](const auto& one) { return one.second; });
    }

    // Whether there is a way over the surface beside stretch_, from its first vertex to its last; it stands
    // in reached_.
    bool find(Over over) {
        const std::uint32_t a = stretch_.front(), b = stretch_.back();
        const Vec3 forward = points_[b] - points_[a];
        using Step = std::pair<double, std::uint32_t>;
        std::priority_queue<Step, std::vector<Step>, std::greater<>> queue;
        reached_.clear();
        reached_[a].price = 0;
        queue.push({0, a});
        while (!queue.empty() && reached_.size() <= most_seen) {
            const std::uint32_t v = queue.top().second;
            queue.pop();
            if (std::exchange(reached_.at(v).is_done, true)) continue;
            if (v == b) return true;
            const Reached at = reached_.at(v);
            for (const std::uint32_t w : graph_.neighbors(v)) {
                const Vec3 step = points_[w] - points_[v];
                if (!may_go_over(w) || (over == Over::onwards && dot(step, forward) <= 0) ||
                    (over == Over::clear && crosses_any(v, w)))
                    continue;
                const auto [found, is_new] = reached_.try_emplace(w);
                Reached& there = found->second;
                if (is_new) there.distance = distance_from_stretch(w);
                if (there.is_done || there.distance > most_mm_) continue;
                const double mean = 0.5 * (at.distance + there.distance) + least_distance * most_mm_;
                const bool is_dear = over == Over::clear && dot(step, forward) < 0;
                const double price = at.price + mean * length(step) * (is_dear ? backwards_price : 1);
                if (!(price < there.price)) continue;
                there.price = price;
                there.from = v;
                queue.push({price, w});
            }
        }
        return false;
    }

    // Segments of contours near the stretch, but for it and ways in its place.
    void find_beside(std::uint32_t r, const Way& way) {
        beside_.clear();
        Box3 near;
        for (const std::uint32_t v : stretch_) near.extend(points_[v]);
        near = near.grown(most_mm_);
        for (std::uint32_t n = 0; n < rings_.size(); ++n) {
            const bool is_own = std::find(own_.begin(), own_.end(), n) != own_.end();
            if (!is_own && !set_.exclusive) continue;
            const Ring& ring = rings_[n];
            const RingWithWays whole = with_ways(ring);
            for (std::size_t k = 0; k < whole.vertices.size(); ++k) {
                const std::uint32_t a = whole.vertices[k],
                                    b = whole.vertices[(k + 1) % whole.vertices.size()];
                Box3 box;
                box.extend(points_[a]);
                box.extend(points_[b]);
                if (!meet(box, near)) continue;
                if (n == r && is_replaced(ring, way, whole.way_of[k], a)) continue;
                beside_.push_back({a, b});
            }
        }
    }

    // Whether what begins at vertex a, of that way or as drawn, is in the place of `way`.
    static bool is_replaced(const Ring& ring, const Way& way, std::size_t of, std::uint32_t a) {
        if (of < ring.ways.size()) return ring.steps(way, ring.ways[of].first) < way.count;
        for (std::uint32_t k = 0; k < way.count; ++k) {
            if (ring.vertices[(way.first + k) % ring.size()] == a) return true;
        }
        return false;
    }

    // Whether the edge, seen along the slice's normal, meets one of beside_ elsewhere than at a common
    // vertex.
    bool crosses_any(std::uint32_t v, std::uint32_t w) const {
        const Vec2 p = at(v), q = at(w);
        return std::any_of(beside_.begin(), beside_.end(), [&](const auto& segment) {
            const auto [a, b] = segment;
            if (a == v || a == w || b == v || b == w) return false;
            const Vec2 s = at(a), t = at(b);
            return orient2d(p, q, s) * orient2d(p, q, t) <= 0 && orient2d(s, t, p) * orient2d(s, t, q) <= 0;
        });
    }

    Vec2 at(std::uint32_t v) const { return slice_.plane.to_plane(points_[v]); }

    bool may_go_over(std::uint32_t v) const {
        return (!taken_.contains(v) && !(set_.exclusive && of_others_.contains(v))) ||
               std::find(stretch_.begin(), stretch_.end(), v) != stretch_.end();
    }

    double distance_from_stretch(std::uint32_t v) const {
        return length(points_[v] - nearest_on_row(stretch_places_, points_[v]));
    }

    // Where the slice's contours are not what those of kept sets are: the way of the structure, of those at
    // fault or, if none of them is, of all, whose segment was tried least often; of these that which goes
    // farthest.
    std::optional<RingAndWay> worst_at_fault() {
        if (std::all_of(own_.begin(), own_.end(), [&](std::uint32_t r) { return rings_[r].ways.empty(); }))
            return std::nullopt;
        std::vector<RingWithWays> whole;
        std::vector<PlaneRing> flat;
        for (std::size_t n = 0; n < rings_.size(); ++n) {
            whole.push_back(with_ways(rings_[n]));
            PlaneRing& ring = flat.emplace_back(PlaneRing{set_.contours_of(slice_)[n].structure, {}});
            for (const std::uint32_t v : whole[n].vertices)
                ring.at.push_back(slice_.plane.to_plane(points_[v]));
        }
        const std::vector<RingSegment> faults = slice_faults(flat, set_.exclusive);
        std::optional<RingAndWay> worst;
        std::pair<std::size_t, double> least;
        const auto note = [&](std::uint32_t r, std::size_t way) {
            const Way& one = rings_[r].ways[way];
            const std::pair key{tried_[{r, one.missed}], -one.farthest_mm};
            if (worst && key >= least) return;
            least = key;
            worst = {r, way};
        };
        for (const RingSegment& fault : faults) {
            const std::size_t way = whole[fault.ring].way_of[fault.place];
            const bool is_own = std::find(own_.begin(), own_.end(), fault.ring) != own_.end();
            if (is_own && way < rings_[fault.ring].ways.size()) note(fault.ring, way);
        }
        for (const std::uint32_t r : own_) {
            for (std::size_t way = 0; set_.exclusive && way < rings_[r].ways.size(); ++way) {
                if (is_in_another(rings_[r], rings_[r].ways[way])) note(r, way);
            }
        }
        for (std::size_t n = 0; !faults.empty() && !worst && n < own_.size(); ++n) {
            for (std::size_t way = 0; way < rings_[own_[n]].ways.size(); ++way) note(own_[n], way);
        }
        return worst;
    }

    void lead_otherwise(std::uint32_t r, const Way& before) {
        ++tried_[{r, before.missed}];
        route(r, before.missed);
        for (std::uint32_t k = 0; k < before.count; ++k) {
            const std::uint32_t n = (before.first + k) % rings_[r].size();
            if (!rings_[r].is_rerouted(n) && is_missed(r, n)) route(r, n);
        }
    }

    Way take_out(std::uint32_t r, std::size_t n) {
        Ring& ring = rings_[r];
        Way way = std::move(ring.ways[n]);
        ring.ways.erase(ring.ways.begin() + static_cast<std::ptrdiff_t>(n));
        for (const std::uint32_t v : way.between) taken_.erase(v);
        // Some were the ring's own.
        for (std::uint32_t k = 0; k <= way.count; ++k)
            taken_.insert(ring.vertices[(way.first + k) % ring.size()]);
        return way;
    }

    std::span<const Vec3> points_;
    const SurfaceGraph& graph_;
    const ContourSet& set_;
    const Slice& slice_;
    std::span<Ring> rings_;
    const double most_mm_;
    std::vector<std::uint32_t> own_;           // rings of the structure
    std::unordered_set<std::uint32_t> taken_;  // vertices that ways must not go over
    // Of the other structures: vertices, rings, and by their ends, the smaller first, those that have a
    // segment, and ways.
    struct Twin {
        std::uint32_t from = 0;
        std::vector<std::uint32_t> between;
    };
    std::unordered_set<std::uint32_t> of_others_;
    std::vector<PlaneRing> others_;
    std::map<std::array<std::uint32_t, 2>, std::vector<std::uint32_t>> sharing_;
    std::map<std::array<std::uint32_t, 2>, Twin> twins_;
    int repairs_ = 0;                                   // of ways at fault
    std::vector<std::uint32_t> stretch_;                // vertices of what a way is sought for
    std::vector<Vec3> stretch_places_;                  // of these
    std::vector<std::array<std::uint32_t, 2>> beside_;  // segments, by vertices, that it must not cross
    std::unordered_map<std::uint32_t, Reached> reached_;
    std::map<std::array<std::uint32_t, 2>, std::size_t> tried_;  // manners, by ring and segment
};

std::vector<Ring> rings_of(const ContourSet& set, std::span<const std::uint32_t> vertex_of,
                           const std::vector<RoutedContour>& routed) {
    std::vector<Ring> rings(set.contours.size());
    for (std::size_t c = 0; c < rings.size(); ++c) {
        const Contour& contour = set.contours[c];
        const auto first = vertex_of.begin() + contour.first_point;
        rings[c].vertices.assign(first, first + contour.point_count);
    }
    for (const RoutedContour& one : routed) rings[one.contour].vertices = one.vertices;
    return rings;
}

}  // namespace

std::vector<RoutedContour> snap_round_segments(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                               const RegionTable& regions, const ContourSet& set,
                                               std::span<const std::uint32_t> vertex_of,
                                               std::vector<RoutedContour> routed,
                                               const SnapRoundingOptions& options) {
    assert(vertex_of.size() == set.points.size() && options.most_mm > 0);
    std::vector<Ring> rings = rings_of(set, vertex_of, routed);
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        const SurfaceGraph graph(mesh.points,
                                 structure_surface(mesh, neighbors, regions, s, options.threads));
        parallel_for(set.slices.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const Slice& slice = set.slices[k];
                SliceSnapRounding(mesh.points, graph, set, slice, s,
                                  {rings.data() + slice.first_contour, slice.contour_count}, options.most_mm)
                    .run();
            }
        });
    }
    std::vector<RoutedContour> all;
    auto next = routed.begin();
    for (std::uint32_t c = 0; c < rings.size(); ++c) {
        const bool was_rerouted = next != routed.end() && next->contour == c;
        if (!was_rerouted && rings[c].ways.empty()) continue;
        RoutedContour& one = all.emplace_back(was_rerouted ? std::move(*next) : RoutedContour{c, {}, 0, 0});
        next += was_rerouted;
        for (const Way& way : rings[c].ways) one.segments += way.replaced;
        // Where a stretch that was re-routed is re-routed once more, its segment counts once.
        one.segments = std::min<std::uint64_t>(one.segments, set.contours[c].point_count);
        for (const Way& way : rings[c].ways) one.farthest_mm = std::max(one.farthest_mm, way.farthest_mm);
        one.vertices = with_ways(rings[c]).vertices;
    }
    return all;
}

}  // namespace anatomesh
