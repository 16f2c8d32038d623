#include "anatomesh/live/draw/area/ring_overlay.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <utility>

#include "anatomesh/contour/overlay/boundary_loops.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/live/draw/area/structure_rings.h"

namespace anatomesh {

namespace {

bool is_odd(const RingTurns& turns) {
    return turns.turns % 2 != 0;
}

// A vertex that was put on an edge and at which nothing turns goes again: the edge is the one that was there.
Ring without_straight_vertices(const Ring& ring, const std::vector<char>& may_go) {
    Ring kept;
    kept.source = ring.source;
    kept.plane = ring.plane;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vec2 next = ring.at[i + 1 < ring.size() ? i + 1 : 0];
        if (may_go[i] && kept.size() > 0 && orient2d(kept.at.back(), ring.at[i], next) == 0) continue;
        kept.push_back(ring.at[i], ring.points[i]);
    }
    return kept;
}

}  // namespace

std::optional<RingOverlay> RingOverlay::make(std::span<const Ring> structure, std::span<const Ring> area,
                                             const Plane& plane) {
    std::vector<Ring> all(structure.begin(), structure.end());
    all.insert(all.end(), area.begin(), area.end());
    std::optional<Arrangement> graph = arrange(all, plane, most_drawn_edges);
    if (!graph) return std::nullopt;
    return RingOverlay(std::move(*graph), structure, area);
}

RingOverlay::RingOverlay(Arrangement graph, std::span<const Ring> structure, std::span<const Ring> area)
    : graph_(std::move(graph)), structure_(structure), area_(area) {
    read_faces();
    read_cycles();
}

void RingOverlay::read_faces() {
    std::vector<double> areas;
    for (const Ring& ring : structure_) areas.push_back(std::abs(signed_area(ring.at)));
    for (const Winding& winding : graph_.windings) {
        FaceSides& face = faces_.emplace_back();
        for (const RingTurns& turns : winding) {
            if (!is_odd(turns)) continue;
            if (turns.ring >= structure_.size()) {
                face.in_area = !face.in_area;
                continue;
            }
            face.in_structure = !face.in_structure;
            // Rings around one face lie in each other, so the smallest is the innermost.
            if (face.innermost < 0 || areas[turns.ring] < areas[static_cast<std::size_t>(face.innermost)]) {
                face.innermost = static_cast<std::int32_t>(turns.ring);
            }
        }
    }
}

void RingOverlay::read_cycles() {
    for (std::uint32_t r = 0; r < structure_.size(); ++r) {
        const std::vector<std::uint32_t>& cycle = graph_.cycles[r];
        std::vector<std::int32_t>& own = own_vertices_.emplace_back(cycle.size(), -1);
        std::size_t next = 0;
        for (std::uint32_t place = 0; place < cycle.size(); ++place) {
            const std::uint32_t from = cycle[place], to = cycle[place + 1 < cycle.size() ? place + 1 : 0];
            if (next < structure_[r].size() && graph_.at[from] == structure_[r].at[next]) {
                own[place] = static_cast<std::int32_t>(next++);
            }
            runs_.push_back({std::min(from, to), std::max(from, to), r, place, from < to});
        }
    }
    std::sort(runs_.begin(), runs_.end(), [](const RunEdge& p, const RunEdge& q) {
        return std::tie(p.a, p.b, p.ring, p.place) < std::tie(q.a, q.b, q.ring, q.place);
    });
}

bool RingOverlay::is_in(std::uint32_t face, std::uint32_t ring) const {
    for (const RingTurns& turns : graph_.windings[face]) {
        if (turns.ring == ring) return is_odd(turns);
    }
    return false;
}

bool RingOverlay::overlaps() const {
    return std::any_of(faces_.begin(), faces_.end(),
                       [](const FaceSides& face) { return face.in_structure && face.in_area; });
}

std::vector<std::int32_t> RingOverlay::parents() const {
    std::vector<std::int32_t> found(structure_.size(), -1);
    for (const Arrangement::Edge& edge : graph_.edges) {
        const RunEdge* run = run_of(edge.a, edge.b);
        if (!run) continue;
        const std::uint32_t outside = is_in(edge.left, run->ring) ? edge.right : edge.left;
        found[run->ring] = faces_[outside].innermost;
    }
    return found;
}

std::uint32_t RingOverlay::crossings_of_area() const {
    std::vector<std::uint32_t> passed;
    for (std::size_t r = structure_.size(); r < graph_.cycles.size(); ++r) {
        passed.insert(passed.end(), graph_.cycles[r].begin(), graph_.cycles[r].end());
    }
    std::sort(passed.begin(), passed.end());
    const auto end = std::unique(passed.begin(), passed.end());
    return static_cast<std::uint32_t>(passed.end() - end);
}

const RingOverlay::RunEdge* RingOverlay::run_of(std::uint32_t from, std::uint32_t to) const {
    const std::pair<std::uint32_t, std::uint32_t> edge = std::minmax(from, to);
    const auto found =
        std::lower_bound(runs_.begin(), runs_.end(), edge,
                         [](const RunEdge& run, const std::pair<std::uint32_t, std::uint32_t>& wanted) {
                             return std::pair(run.a, run.b) < wanted;
                         });
    if (found == runs_.end() || found->a != edge.first || found->b != edge.second) return nullptr;
    return &*found;
}

// The number of an end of the edge among the vertices of its ring, or -1 if it is none of them.
std::int32_t RingOverlay::own_vertex(const RunEdge& run, std::uint32_t vertex) const {
    const std::vector<std::int32_t>& own = own_vertices_[run.ring];
    const bool is_first = vertex == (run.forward ? run.a : run.b);
    return own[is_first ? run.place : (run.place + 1) % own.size()];
}

// The ring of a loop of vertices, in its order.
Ring RingOverlay::traced(std::span<const std::uint32_t> loop) const {
    Ring ring;
    std::vector<char> may_go;
    const std::size_t n = loop.size();
    for (std::size_t i = 0; i < n; ++i) {
        const RunEdge* in = run_of(loop[(i + n - 1) % n], loop[i]);
        const RunEdge* out = run_of(loop[i], loop[(i + 1) % n]);
        may_go.push_back(in && out && in->ring == out->ring && own_vertex(*out, loop[i]) < 0);
        // Of points above each other the graph has the smallest; a ring keeps its own.
        const RunEdge* run = in && (!out || in->ring < out->ring) ? in : out;
        const std::int32_t own = run ? own_vertex(*run, loop[i]) : -1;
        ring.push_back(graph_.at[loop[i]], own < 0
                                               ? graph_.points[loop[i]]
                                               : structure_[run->ring].points[static_cast<std::size_t>(own)]);
    }
    return without_straight_vertices(ring, may_go);
}

// Turns the loop to run and begin as its owner does, and reads it.
RegionRing RingOverlay::ring_of_loop(std::span<const std::uint32_t> loop) const {
    constexpr auto last = std::numeric_limits<std::uint32_t>::max();
    RegionRing result;
    std::vector<std::uint32_t> turned(loop.begin(), loop.end());
    const std::size_t n = loop.size();
    std::uint32_t owner = last;
    for (std::size_t i = 0; i < n; ++i) {
        if (const RunEdge* run = run_of(loop[i], loop[(i + 1) % n])) owner = std::min(owner, run->ring);
    }
    if (owner == last) {
        result.ring = traced(turned);
        result.ring.source = drawn_now;
        return result;
    }
    // The start: the owner's first vertex, or where none is left, the first place of its cycle.
    std::pair<std::uint32_t, std::uint32_t> best{last, last};
    std::size_t start = 0;
    bool forward = true;
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t from = loop[i], to = loop[(i + 1) % n];
        const RunEdge* run = run_of(from, to);
        if (!run || run->ring != owner) continue;
        const bool along = run->forward == (from < to);
        for (const std::uint32_t vertex : {from, to}) {
            const std::int32_t own = own_vertex(*run, vertex);
            const bool is_first = vertex == (run->forward ? run->a : run->b);
            const auto size = static_cast<std::uint32_t>(own_vertices_[owner].size());
            const std::pair rank{own < 0 ? last : static_cast<std::uint32_t>(own),
                                 is_first ? run->place : (run->place + 1) % size};
            if (!(rank < best)) continue;
            best = rank;
            start = vertex == from ? i : (i + 1) % n;
            forward = along;
        }
    }
    std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(start), turned.end());
    if (!forward) std::reverse(turned.begin() + 1, turned.end());
    result.owner = static_cast<std::int32_t>(owner);
    result.place = best.second;
    result.ring = traced(turned);
    const Ring& before = structure_[owner];
    result.ring.source = before.source;
    result.ring.plane = before.plane;
    result.is_unchanged = result.ring.points == before.points && result.ring.at == before.at;
    return result;
}

Region RingOverlay::region(const std::vector<char>& inside) const {
    std::vector<BoundaryEdge> edges;
    for (const Arrangement::Edge& edge : graph_.edges) {
        if (inside[edge.left] == inside[edge.right]) continue;
        edges.push_back(inside[edge.left] ? BoundaryEdge{edge.a, edge.b} : BoundaryEdge{edge.b, edge.a});
    }
    Region region;
    std::vector<std::uint32_t> vertices;
    for (const std::vector<std::uint32_t>& loop : boundary_loops(graph_.at, edges)) {
        vertices.clear();
        for (const std::uint32_t edge : loop) vertices.push_back(edges[edge].from);
        RegionRing found = ring_of_loop(vertices);
        const double area = std::abs(signed_area(found.ring.at));
        if (!found.is_unchanged && 2 * area <= sliver_width_mm * perimeter(found.ring.at)) {
            region.sliver_area_mm2 += area;
            continue;
        }
        if (found.owner < 0) found.place = static_cast<std::uint32_t>(region.rings.size());
        region.rings.push_back(std::move(found));
    }
    std::stable_sort(region.rings.begin(), region.rings.end(), [](const RegionRing& p, const RegionRing& q) {
        const auto owner = [](const RegionRing& ring) { return static_cast<std::uint32_t>(ring.owner); };
        return std::pair(owner(p), p.place) < std::pair(owner(q), q.place);
    });
    return region;
}

}  // namespace anatomesh
