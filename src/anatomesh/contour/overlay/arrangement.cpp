#include "anatomesh/contour/overlay/arrangement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

constexpr int most_passes = 64;  // Edges are cut until none crosses, or so often. [passes; >= 1; B]
// A crossing this close to a vertex is that vertex. [mm; 0 to 0.01; D digits of files]
constexpr double snap_mm = 1e-6;
// Edges that cross at a smaller angle run along each other: rounding moves their crossing by more than snap_mm. [sine of
// the angle; 0 to 1e-6; D rounding]
constexpr double parallel_sine = 1e-9;
constexpr std::uint32_t none = 0xffffffff;  // Marks no vertex or edge. [index; largest number; D]

struct CoordinateLess {
    bool operator()(Vec2 p, Vec2 q) const { return lexicographic_less(p, q); }
};

// Where the lines ab and cd cross, rounded. Requires: they do not run along each other.
Vec2 crossing_of(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    const Vec2 along = b - a, other = d - c;
    const double t = cross(c - a, other) / cross(along, other);
    return a + t * along;
}

// Cuts the rings' edges until they meet at vertices only.
class Cutter {
  public:
    Cutter(std::span<const Ring> rings, const Plane& plane, std::size_t most_edges)
        : plane_(plane), most_edges_(most_edges) {
        add_vertices(rings);
    }

    bool run() {
        for (int pass = 0; pass < most_passes; ++pass) {
            find_splits();
            if (too_many_) return false;
            if (splits_.empty()) return true;
            apply_splits();
        }
        return false;
    }

    std::vector<Vec2> at;
    std::vector<Vec3> points;
    std::vector<std::vector<std::uint32_t>> cycles;

  private:
    // An edge of a cycle and a vertex on it.
    struct Split {
        std::uint32_t edge = 0;
        std::uint32_t vertex = 0;
    };

    // One vertex for equal in-plane coordinates; of different points above each other the smallest is taken.
    void add_vertices(std::span<const Ring> rings) {
        for (const Ring& ring : rings) {
            for (std::size_t i = 0; i < ring.size(); ++i) {
                const auto [entry, is_new] = ids_.try_emplace(ring.at[i], 0u);
                if (is_new) entry->second = static_cast<std::uint32_t>(at.size());
                if (is_new) at.push_back(ring.at[i]), points.push_back(ring.points[i]);
                Vec3& point = points[entry->second];
                if (lexicographic_less(ring.points[i], point)) point = ring.points[i];
            }
        }
        for (const Ring& ring : rings) {
            std::vector<std::uint32_t> cycle;
            for (Vec2 p : ring.at) cycle.push_back(ids_.find(p)->second);
            cycles.push_back(std::move(cycle));
        }
    }

    // The vertex for a crossing: one that is there already within the snapping distance, or a new one. The
    // plane's coordinates of a new vertex are those of its point in space, as for every other vertex.
    std::uint32_t vertex_near(Vec2 where) {
        if (cells_.empty()) {
            for (std::uint32_t v = 0; v < at.size(); ++v) cells_[cell_of(at[v])].push_back(v);
        }
        const Vec3 point = plane_.to_space(where);
        const Vec2 rounded = plane_.to_plane(point);
        std::uint32_t nearest = none;
        double distance = snap_mm;
        const auto [x, y] = cell_of(rounded);
        for (std::int64_t cx = x - 1; cx <= x + 1; ++cx) {
            for (std::int64_t cy = y - 1; cy <= y + 1; ++cy) {
                const auto cell = cells_.find({cx, cy});
                if (cell == cells_.end()) continue;
                for (std::uint32_t v : cell->second) {
                    const double d = length(at[v] - rounded);
                    if (d < distance || (d == distance && v < nearest)) distance = d, nearest = v;
                }
            }
        }
        if (nearest != none) return nearest;
        const auto vertex = static_cast<std::uint32_t>(at.size());
        at.push_back(rounded);
        points.push_back(point);
        cells_[{x, y}].push_back(vertex);
        return vertex;
    }

    static std::pair<std::int64_t, std::int64_t> cell_of(Vec2 p) {
        return {static_cast<std::int64_t>(std::floor(p.x / snap_mm)),
                static_cast<std::int64_t>(std::floor(p.y / snap_mm))};
    }

    void find_splits() {
        splits_.clear();
        ends_.clear();
        std::vector<Segment2> segments;
        for (const auto& cycle : cycles) {
            for (std::size_t i = 0; i < cycle.size(); ++i) {
                const std::uint32_t a = cycle[i], b = cycle[i + 1 < cycle.size() ? i + 1 : 0];
                ends_.push_back({a, b});
                segments.push_back({at[a], at[b]});
            }
        }
        too_many_ = segments.size() > most_edges_;
        if (too_many_) return;
        const SegmentIndex index(std::move(segments));
        index.for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            compare(i, j);
            too_many_ = splits_.size() > most_edges_;
            return !too_many_;
        });
    }

    void split(std::uint32_t edge, std::uint32_t vertex) {
        if (vertex != ends_[edge].first && vertex != ends_[edge].second) splits_.push_back({edge, vertex});
    }

    static bool run_along_each_other(Vec2 along, Vec2 other) {
        return std::abs(cross(along, other)) <= parallel_sine * length(along) * length(other);
    }

    // Splits an edge at a vertex that lies beside it between its ends.
    void split_beside(std::uint32_t edge, std::uint32_t vertex) {
        const Vec2 a = at[ends_[edge].first], along = at[ends_[edge].second] - a;
        const double t = dot(at[vertex] - a, along);
        if (t > 0 && t < dot(along, along)) split(edge, vertex);
    }

    // Splits edges i and j where they meet other than at a common end.
    void compare(std::uint32_t i, std::uint32_t j) {
        const auto [a, b] = ends_[i];
        const auto [c, d] = ends_[j];
        if ((a == c && b == d) || (a == d && b == c)) return;
        bool touches = a == c || a == d || b == c || b == d;
        for (std::uint32_t vertex : {c, d}) {
            if (vertex == a || vertex == b || !on_segment(at[a], at[b], at[vertex])) continue;
            split(i, vertex);
            touches = true;
        }
        for (std::uint32_t vertex : {a, b}) {
            if (vertex == c || vertex == d || !on_segment(at[c], at[d], at[vertex])) continue;
            split(j, vertex);
            touches = true;
        }
        if (touches) return;
        if (segment_contact(at[a], at[b], at[c], at[d]) != SegmentContact::cross) return;
        if (run_along_each_other(at[b] - at[a], at[d] - at[c])) {
            const std::size_t before = splits_.size();
            for (std::uint32_t vertex : {c, d}) split_beside(i, vertex);
            for (std::uint32_t vertex : {a, b}) split_beside(j, vertex);
            // Where no end lies between, each end lies at one of the other edge.
            if (splits_.size() == before) split(i, c);
            return;
        }
        // Which edge is named first must not matter to the rounding: the smaller vertex leads.
        auto first = std::minmax(a, b), second = std::minmax(c, d);
        std::pair<std::uint32_t, std::uint32_t> p = first, q = second;
        if (q < p) std::swap(p, q);
        const std::uint32_t vertex =
            vertex_near(crossing_of(at[p.first], at[p.second], at[q.first], at[q.second]));
        split(i, vertex);
        split(j, vertex);
    }

    // Replaces every split edge by the chain through its new vertices, in their order along it.
    void apply_splits() {
        std::sort(splits_.begin(), splits_.end(), [&](const Split& p, const Split& q) {
            if (p.edge != q.edge) return p.edge < q.edge;
            const Vec2 a = at[ends_[p.edge].first], along = at[ends_[p.edge].second] - a;
            const double s = dot(at[p.vertex] - a, along), t = dot(at[q.vertex] - a, along);
            return s != t ? s < t : p.vertex < q.vertex;
        });
        std::size_t next = 0;
        std::uint32_t edge = 0;
        for (auto& cycle : cycles) {
            std::vector<std::uint32_t> longer;
            for (std::uint32_t vertex : cycle) {
                if (longer.empty() || longer.back() != vertex) longer.push_back(vertex);
                for (; next < splits_.size() && splits_[next].edge == edge; ++next) {
                    if (longer.back() != splits_[next].vertex) longer.push_back(splits_[next].vertex);
                }
                ++edge;
            }
            while (longer.size() > 1 && longer.back() == longer.front()) longer.pop_back();
            cycle = std::move(longer);
        }
    }

    const Plane& plane_;
    const std::size_t most_edges_;
    bool too_many_ = false;
    std::map<Vec2, std::uint32_t, CoordinateLess> ids_;  // of the rings' vertices
    std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::uint32_t>> cells_;  // of all vertices
    std::vector<std::pair<std::uint32_t, std::uint32_t>>
        ends_;  // of the edges of all cycles, behind one another
    std::vector<Split> splits_;
};

Winding sum(const Winding& winding, const Winding& change, std::int32_t sign) {
    Winding result;
    auto p = winding.begin();
    auto q = change.begin();
    while (p != winding.end() || q != change.end()) {
        if (q == change.end() || (p != winding.end() && p->ring < q->ring)) {
            result.push_back(*p++);
        } else if (p == winding.end() || q->ring < p->ring) {
            result.push_back({q->ring, sign * q->turns});
            ++q;
        } else {
            const std::int32_t turns = p->turns + sign * q->turns;
            if (turns != 0) result.push_back({p->ring, turns});
            ++p, ++q;
        }
    }
    return result;
}

// Gives the edges of the plane graph their windings. Half-edge 2e runs a -> b of edge e, 2e + 1 back.
class FaceWinder {
  public:
    explicit FaceWinder(Arrangement& graph) : graph_(graph) {}

    void run(const std::vector<std::vector<std::uint32_t>>& cycles) {
        collect_edges(cycles);
        sort_around_vertices();
        link();
        wind();
    }

  private:
    std::uint32_t from(std::uint32_t half) const {
        const Arrangement::Edge& edge = graph_.edges[half / 2];
        return half % 2 == 0 ? edge.a : edge.b;
    }
    std::uint32_t to(std::uint32_t half) const { return from(half ^ 1); }

    // Edges in the order in which the rings first run them, with the change of winding from right to left.
    void collect_edges(const std::vector<std::vector<std::uint32_t>>& cycles) {
        struct Piece {
            std::uint32_t a, b, ring;
            std::int32_t turns;
            std::size_t order;
        };
        std::vector<Piece> pieces;
        for (std::uint32_t r = 0; r < cycles.size(); ++r) {
            const auto& cycle = cycles[r];
            for (std::size_t i = 0; cycle.size() > 1 && i < cycle.size(); ++i) {
                std::uint32_t a = cycle[i], b = cycle[i + 1 < cycle.size() ? i + 1 : 0];
                const bool forward = lexicographic_less(graph_.at[a], graph_.at[b]);
                if (!forward) std::swap(a, b);
                pieces.push_back({a, b, r, forward ? 1 : -1, pieces.size()});
            }
        }
        std::sort(pieces.begin(), pieces.end(), [](const Piece& p, const Piece& q) {
            return std::tie(p.a, p.b, p.ring, p.order) < std::tie(q.a, q.b, q.ring, q.order);
        });
        struct Found {
            Arrangement::Edge edge;
            Winding change;
            std::size_t order;
        };
        std::vector<Found> found;
        for (std::size_t begin = 0, end = 0; begin < pieces.size(); begin = end) {
            Found next{{pieces[begin].a, pieces[begin].b, 0, 0}, {}, pieces.size()};
            for (; end < pieces.size() && pieces[end].a == next.edge.a && pieces[end].b == next.edge.b;
                 ++end) {
                next.order = std::min(next.order, pieces[end].order);
                if (next.change.empty() || next.change.back().ring != pieces[end].ring) {
                    next.change.push_back({pieces[end].ring, 0});
                }
                next.change.back().turns += pieces[end].turns;
            }
            std::erase_if(next.change, [](const RingTurns& turns) { return turns.turns == 0; });
            if (!next.change.empty()) found.push_back(std::move(next));
        }
        std::sort(found.begin(), found.end(),
                  [](const Found& p, const Found& q) { return p.order < q.order; });
        for (Found& next : found) {
            graph_.edges.push_back(next.edge);
            change_.push_back(std::move(next.change));
        }
    }

    // Half-edges leaving each vertex, counter-clockwise from just after the direction -y.
    void sort_around_vertices() {
        const std::uint32_t halves = static_cast<std::uint32_t>(2 * graph_.edges.size());
        first_.assign(graph_.at.size() + 1, 0);
        for (std::uint32_t half = 0; half < halves; ++half) ++first_[from(half) + 1];
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        around_.resize(halves);
        std::vector<std::uint32_t> place(first_.begin(), first_.end() - 1);
        for (std::uint32_t half = 0; half < halves; ++half) around_[place[from(half)]++] = half;
        for (std::uint32_t v = 0; v < graph_.at.size(); ++v) {
            // Even half-edges go right (or straight up), odd ones left (or straight down).
            std::sort(around_.begin() + first_[v], around_.begin() + first_[v + 1],
                      [&](std::uint32_t p, std::uint32_t q) {
                          if (p % 2 != q % 2) return p % 2 < q % 2;
                          return orient2d(graph_.at[v], graph_.at[to(p)], graph_.at[to(q)]) > 0;
                      });
        }
    }

    // The next half-edge along the face to the left: at its end the first one clockwise from where it came.
    void link() {
        next_.resize(around_.size());
        std::vector<std::uint32_t> position(around_.size());
        for (std::uint32_t i = 0; i < around_.size(); ++i) position[around_[i]] = i;
        for (std::uint32_t half = 0; half < around_.size(); ++half) {
            const std::uint32_t v = to(half), back = position[half ^ 1];
            next_[half] = around_[back == first_[v] ? first_[v + 1] - 1 : back - 1];
        }
    }

    // Component by component: the face outside one from what lies below its smallest vertex, the others by
    // crossing edges.
    void wind() {
        std::vector<Segment2> segments;
        for (const Arrangement::Edge& edge : graph_.edges)
            segments.push_back({graph_.at[edge.a], graph_.at[edge.b]});
        const SegmentIndex index(std::move(segments));
        winding_.assign(around_.size(), none);
        std::vector<std::uint32_t> vertices(graph_.at.size());
        std::iota(vertices.begin(), vertices.end(), 0u);
        std::sort(vertices.begin(), vertices.end(), [&](std::uint32_t p, std::uint32_t q) {
            return lexicographic_less(graph_.at[p], graph_.at[q]);
        });
        std::vector<std::uint32_t> hits;
        for (std::uint32_t v : vertices) {
            if (first_[v] == first_[v + 1] || winding_[around_[first_[v]]] != none) continue;
            hits.clear();
            index.below(graph_.at[v], hits);
            Winding outside;
            for (std::uint32_t hit : hits) outside = sum(outside, change_[hit], 1);
            // The smallest vertex's edges all go right, so the last one has the outside on its left.
            spread(around_[first_[v + 1] - 1], std::move(outside));
        }
        for (std::uint32_t e = 0; e < graph_.edges.size(); ++e) {
            graph_.edges[e].left = winding_[2 * e];
            graph_.edges[e].right = winding_[2 * e + 1];
        }
    }

    void spread(std::uint32_t start, Winding winding) {
        std::vector<std::uint32_t> open{start};
        mark_face(start, std::move(winding), open);
        while (!open.empty()) {
            const std::uint32_t half = open.back();
            open.pop_back();
            const std::uint32_t twin = half ^ 1;
            if (winding_[twin] != none) continue;
            const std::int32_t sign = half % 2 == 0 ? -1 : 1;
            mark_face(twin, sum(graph_.windings[winding_[half]], change_[half / 2], sign), open);
        }
    }

    void mark_face(std::uint32_t start, Winding winding, std::vector<std::uint32_t>& open) {
        const auto id = static_cast<std::uint32_t>(graph_.windings.size());
        graph_.windings.push_back(std::move(winding));
        std::uint32_t half = start;
        do {
            winding_[half] = id;
            open.push_back(half);
            half = next_[half];
        } while (half != start);
    }

    Arrangement& graph_;
    std::vector<Winding> change_;                       // per edge, from right to left
    std::vector<std::uint32_t> first_, around_, next_;  // half-edges around vertices; along faces
    std::vector<std::uint32_t> winding_;                // per half-edge: of the face to its left
};

}  // namespace

std::optional<Arrangement> arrange(std::span<const Ring> rings, const Plane& plane, std::size_t most_edges) {
    Cutter cutter(rings, plane, most_edges);
    if (!cutter.run()) return std::nullopt;
    Arrangement graph;
    graph.at = std::move(cutter.at);
    graph.points = std::move(cutter.points);
    graph.cycles = std::move(cutter.cycles);
    FaceWinder(graph).run(graph.cycles);
    return graph;
}

}  // namespace anatomesh
