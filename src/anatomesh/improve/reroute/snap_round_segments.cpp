#include "anatomesh/improve/reroute/snap_round_segments.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <map>
#include <optional>
#include <unordered_set>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/improve/reroute/edge_path.h"
#include "anatomesh/improve/reroute/neighbor_rings.h"
#include "anatomesh/improve/reroute/ring_ways.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/model/surface_graph.h"

namespace anatomesh {

namespace {

constexpr int most_repairs = 200;  // of ways at fault in a slice; more go [attempts; > 0; B]

// How a missed segment is re-routed: with so many segments before and after it.
struct Routing {
    std::uint32_t before, after;
    EdgePathRule rule;
};
constexpr int rounds = 3;  // over the missed segments of a slice [passes; > 0; B]
// The routings that are tried in turn. [segments; >= 0; M 2026-11 dense freehand planes]
constexpr std::array<Routing, 9> routings{{{0, 0, EdgePathRule::all},
                                           {0, 0, EdgePathRule::onwards},
                                           {0, 0, EdgePathRule::clear},
                                           {0, 1, EdgePathRule::clear},
                                           {1, 0, EdgePathRule::clear},
                                           {1, 1, EdgePathRule::clear},
                                           {0, 2, EdgePathRule::clear},
                                           {2, 0, EdgePathRule::clear},
                                           {2, 2, EdgePathRule::clear}}};

// Re-routes the contours of one structure in one slice.
class SliceSnapRounding {
  public:
    // `rings`: of all contours of the slice.
    SliceSnapRounding(std::span<const Vec3> points, const SurfaceGraph& graph, const ContourSet& set,
                      const Slice& slice, std::uint32_t structure, std::span<RoutedRing> rings,
                      double most_mm)
        : points_(points),
          graph_(graph),
          set_(set),
          slice_(slice),
          rings_(rings),
          most_mm_(most_mm),
          others_(points, slice.plane),
          search_(points, graph, slice.plane, most_mm) {
        const std::span<const Contour> contours = set.contours_of(slice);
        for (std::uint32_t n = 0; n < contours.size(); ++n) {
            if (contours[n].structure == structure) own_.push_back(n);
        }
    }

    void run() {
        // Nothing is known of what such contours do to others.
        const auto lost_a_vertex = [](const RoutedRing& ring) {
            return std::find(ring.vertices.begin(), ring.vertices.end(), no_cell) != ring.vertices.end();
        };
        if (std::any_of(rings_.begin(), rings_.end(), lost_a_vertex) || !misses_any()) return;
        for (const std::uint32_t r : own_)
            taken_.insert(rings_[r].vertices.begin(), rings_[r].vertices.end());
        look_at_others();
        // What stood in the way of others may be re-routed otherwise after a round.
        for (int round = 0; round < rounds && route_missed(); ++round) {
            while (const std::optional<RingAndWay> worst = worst_at_fault()) {
                const RingWay before = take_out(worst->ring, worst->way);
                if (++repairs_ <= most_repairs) route_otherwise(worst->ring, before);
            }
            // Ways that are sound stay.
            tried_.clear();
            for (const std::uint32_t r : own_) {
                for (const RingWay& way : rings_[r].ways) tried_[{r, way.missed}] = routings.size();
            }
        }
    }

  private:
    struct RingAndWay {
        std::uint32_t ring;
        std::size_t way;
    };

    bool is_missed(std::uint32_t r, std::uint32_t n) const {
        const RoutedRing& ring = rings_[r];
        return !graph_.chain(ring.vertices[n], ring.vertices[(n + 1) % ring.size()]);
    }

    bool misses_any() const {
        return std::any_of(own_.begin(), own_.end(), [&](std::uint32_t r) {
            for (std::uint32_t n = 0; n < rings_[r].size(); ++n) {
                if (is_missed(r, n)) return true;
            }
            return false;
        });
    }

    // Whether any was re-routed.
    bool route_missed() {
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
        RoutedRing& ring = rings_[r];
        RingWay way{(n + ring.size() - routing.before) % ring.size(),
                    1 + routing.before + routing.after,
                    n,
                    0,
                    {},
                    0};
        if (way.count + 2 > ring.size()) return false;
        std::vector<std::uint32_t> stretch;
        for (std::uint32_t k = 0; k <= way.count; ++k) stretch.push_back(ring.vertex(way.first + k));
        for (std::uint32_t k = 0; k < way.count; ++k)
            way.replaced += !graph_.chain(stretch[k], stretch[k + 1]);
        search_.begin(std::move(stretch));
        const auto is_inside = [&](const RingWay& other) {
            return ring.steps(way, other.first) + other.count <= way.count;
        };
        for (std::uint32_t k = 0; k < way.count; ++k) {
            const std::uint32_t covered = (way.first + k) % ring.size();
            for (const RingWay& other : ring.ways) {
                if (ring.steps(other, covered) < other.count && !is_inside(other)) return false;
            }
        }
        if (way.count > 1 || !take_twin(way)) {
            if (routing.rule == EdgePathRule::clear) find_beside(r, way);
            std::optional<std::vector<std::uint32_t>> between =
                search_.find(routing.rule, beside_, [&](std::uint32_t v) { return may_pass(v); });
            if (!between) return false;
            way.between = std::move(*between);
        }
        way.farthest_mm = search_.farthest(way.between);
        if (way.farthest_mm > most_mm_) return false;
        for (std::size_t k = ring.ways.size(); k-- > 0;) {
            if (is_inside(ring.ways[k])) take_out(r, k);
        }
        taken_.insert(way.between.begin(), way.between.end());
        const auto place = std::find_if(ring.ways.begin(), ring.ways.end(),
                                        [&](const RingWay& other) { return other.first > way.first; });
        ring.ways.insert(place, std::move(way));
        return true;
    }

    void look_at_others() {
        for (std::uint32_t n = 0; n < rings_.size(); ++n) {
            if (!is_own(n)) others_.add(rings_[n], set_.contours_of(slice_)[n].structure);
        }
    }

    bool is_own(std::uint32_t r) const { return std::find(own_.begin(), own_.end(), r) != own_.end(); }

    // A segment of a common wall goes the way of the other structure's, if that is edges of this one too.
    bool take_twin(RingWay& way) const {
        std::optional<std::vector<std::uint32_t>> between =
            others_.way_between(search_.stretch().front(), search_.stretch().back());
        if (!between || !search_.are_edges(*between)) return false;
        way.between = std::move(*between);
        return true;
    }

    // Segments of contours near the stretch, but for it and ways in its place.
    void find_beside(std::uint32_t r, const RingWay& way) {
        beside_.clear();
        Box3 near;
        for (const std::uint32_t v : search_.stretch()) near.extend(points_[v]);
        near = near.grown(most_mm_);
        for (std::uint32_t n = 0; n < rings_.size(); ++n) {
            if (!is_own(n) && !set_.exclusive) continue;
            const RoutedRing& ring = rings_[n];
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
    static bool is_replaced(const RoutedRing& ring, const RingWay& way, std::size_t of, std::uint32_t a) {
        if (of < ring.ways.size()) return ring.steps(way, ring.ways[of].first) < way.count;
        for (std::uint32_t k = 0; k < way.count; ++k) {
            if (ring.vertex(way.first + k) == a) return true;
        }
        return false;
    }

    bool may_pass(std::uint32_t v) const {
        const std::vector<std::uint32_t>& stretch = search_.stretch();
        return (!taken_.contains(v) && !(set_.exclusive && others_.has(v))) ||
               std::find(stretch.begin(), stretch.end(), v) != stretch.end();
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
            const RingWay& one = rings_[r].ways[way];
            const std::pair key{tried_[{r, one.missed}], -one.farthest_mm};
            if (worst && key >= least) return;
            least = key;
            worst = {r, way};
        };
        for (const RingSegment& fault : faults) {
            const std::size_t way = whole[fault.ring].way_of[fault.place];
            if (is_own(fault.ring) && way < rings_[fault.ring].ways.size()) note(fault.ring, way);
        }
        for (const std::uint32_t r : own_) {
            for (std::size_t way = 0; set_.exclusive && way < rings_[r].ways.size(); ++way) {
                if (others_.hold(rings_[r], rings_[r].ways[way])) note(r, way);
            }
        }
        for (std::size_t n = 0; !faults.empty() && !worst && n < own_.size(); ++n) {
            for (std::size_t way = 0; way < rings_[own_[n]].ways.size(); ++way) note(own_[n], way);
        }
        return worst;
    }

    void route_otherwise(std::uint32_t r, const RingWay& before) {
        ++tried_[{r, before.missed}];
        route(r, before.missed);
        for (std::uint32_t k = 0; k < before.count; ++k) {
            const std::uint32_t n = (before.first + k) % rings_[r].size();
            if (!rings_[r].is_rerouted(n) && is_missed(r, n)) route(r, n);
        }
    }

    RingWay take_out(std::uint32_t r, std::size_t n) {
        RoutedRing& ring = rings_[r];
        RingWay way = std::move(ring.ways[n]);
        ring.ways.erase(ring.ways.begin() + static_cast<std::ptrdiff_t>(n));
        for (const std::uint32_t v : way.between) taken_.erase(v);
        // Some were the ring's own.
        for (std::uint32_t k = 0; k <= way.count; ++k) taken_.insert(ring.vertex(way.first + k));
        return way;
    }

    std::span<const Vec3> points_;
    const SurfaceGraph& graph_;
    const ContourSet& set_;
    const Slice& slice_;
    std::span<RoutedRing> rings_;
    const double most_mm_;
    std::vector<std::uint32_t> own_;           // rings of the structure
    std::unordered_set<std::uint32_t> taken_;  // vertices that ways must not go over
    NeighborRings others_;                     // of the other structures
    EdgePathSearch search_;
    int repairs_ = 0;                                   // of ways at fault
    std::vector<std::array<std::uint32_t, 2>> beside_;  // segments, by vertices, that it must not cross
    std::map<std::array<std::uint32_t, 2>, std::size_t> tried_;  // manners, by ring and segment
};

std::vector<RoutedRing> rings_of(const ContourSet& set, std::span<const std::uint32_t> vertex_of,
                                 const std::vector<RoutedContour>& routed) {
    std::vector<RoutedRing> rings(set.contours.size());
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
    std::vector<RoutedRing> rings = rings_of(set, vertex_of, routed);
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
        for (const RingWay& way : rings[c].ways) one.segments += way.replaced;
        // Where a stretch that was re-routed is re-routed once more, its segment counts once.
        one.segments = std::min<std::uint64_t>(one.segments, set.contours[c].point_count);
        for (const RingWay& way : rings[c].ways) one.farthest_mm = std::max(one.farthest_mm, way.farthest_mm);
        one.vertices = with_ways(rings[c]).vertices;
    }
    return all;
}

}  // namespace anatomesh
