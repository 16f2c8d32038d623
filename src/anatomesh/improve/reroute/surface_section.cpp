#include "anatomesh/improve/reroute/surface_section.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <utility>

namespace anatomesh {

namespace {

constexpr std::size_t most_walked = 20000;  // of the section's points, for a way [points; > 0; B]

SectionNode edge_node(std::uint32_t p, std::uint32_t q) {
    return {std::min(p, q), std::max(p, q)};
}

}  // namespace

SurfaceSection::SurfaceSection(EditContext& edit, const Plane& plane, std::uint32_t structure,
                               double in_plane_mm, std::span<const std::uint32_t> in_plane)
    : edit_(edit),
      plane_(plane),
      structure_(structure),
      incidence_(edit),
      in_plane_mm_(in_plane_mm),
      in_plane_(in_plane) {}

std::optional<std::vector<SectionPoint>> SurfaceSection::shortest_way(
    std::span<const WayEnd> starts, std::span<const WayEnd> ends,
    const std::function<bool(const SectionPoint&)>& allowed) {
    struct Reached {
        double length = HUGE_VAL;
        SectionNode before;
    };
    std::map<SectionNode, Reached> reached;
    std::map<SectionNode, double> price_of_end;
    for (const WayEnd& end : ends) price_of_end[{end.vertex, no_cell}] = end.price;
    using Waiting = std::pair<double, SectionNode>;
    std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> queue;
    for (const WayEnd& start : starts) {
        const SectionNode node{start.vertex, no_cell};
        reached[node] = {start.price, node};
        queue.emplace(start.price, node);
    }
    SectionNode last;
    double whole = HUGE_VAL;
    std::vector<SectionNode> next;
    while (!queue.empty() && queue.top().first < whole && reached.size() < most_walked) {
        const auto [so_far, node] = queue.top();
        queue.pop();
        if (so_far > reached[node].length) continue;
        if (const auto end = price_of_end.find(node); end != price_of_end.end()) {
            if (so_far + end->second < whole) {
                whole = so_far + end->second;
                last = node;
            }
            continue;
        }
        const Vec3 here = place(node);
        beside(node, next);
        for (const SectionNode& other : next) {
            const auto known = reached.find(other);
            const bool is_start = known != reached.end() && known->second.before == other;
            const Vec3 there = place(other);
            if (is_start || (known == reached.end() && !allowed({other, there}))) continue;
            const double all = so_far + length(there - here);
            if (known != reached.end() && !(all < known->second.length)) continue;
            reached[other] = {all, node};
            queue.emplace(all, other);
        }
    }
    if (whole == HUGE_VAL) return std::nullopt;
    std::vector<SectionPoint> way{{last, place(last)}};
    for (SectionNode before = reached[last].before; before != way.back().node;
         before = reached[before].before)
        way.push_back({before, place(before)});
    std::reverse(way.begin(), way.end());
    return way;
}

int SurfaceSection::side(std::uint32_t v) const {
    const double height = plane_.signed_distance(edit_.mesh.point(v));
    if (std::abs(height) <= in_plane_mm_ || std::binary_search(in_plane_.begin(), in_plane_.end(), v))
        return 0;
    return height > 0 ? 1 : -1;
}

Vec3 SurfaceSection::place(const SectionNode& node) const {
    const Vec3 p = edit_.mesh.point(node.p);
    if (node.is_vertex()) return p;
    const Vec3 q = edit_.mesh.point(node.q);
    const double from = plane_.signed_distance(p), to = plane_.signed_distance(q);
    return p + (from / (from - to)) * (q - p);
}

// Those beside a node, in no order.
void SurfaceSection::beside(const SectionNode& node, std::vector<SectionNode>& found) {
    found.clear();
    if (node.is_vertex()) {
        edit_.mesh.star(node.p, edit_.star);
        for (const std::uint32_t c : edit_.star) add_facets_at(c, node.p, found);
        return;
    }
    if (!incidence_.find_ring(node.p, node.q)) return;
    const EdgeRing& ring = edit_.ring;
    for (std::size_t n = 0; n < ring.cells.size(); ++n) {
        const std::uint32_t before = ring.cells[(n + ring.cells.size() - 1) % ring.cells.size()];
        if (incidence_.has(before, structure_) != incidence_.has(ring.cells[n], structure_))
            add_across(node, ring.ring[n], found);
    }
}

// What faces the vertex in the cell's facets on the surface.
void SurfaceSection::add_facets_at(std::uint32_t c, std::uint32_t v, std::vector<SectionNode>& found) const {
    if (!incidence_.has(c, structure_)) return;
    const Cell& cell = edit_.mesh.cell(c);
    for (int i = 0; i < 4; ++i) {
        if (cell[i] == v) continue;
        const std::uint32_t beyond = edit_.mesh.neighbor(c, i);
        if (beyond != no_cell && incidence_.has(beyond, structure_)) continue;
        const auto [p, q] = others_of_facet(cell, i, v);
        const int at_p = side(p), at_q = side(q);
        if (at_p == 0) found.push_back({p, no_cell});
        if (at_q == 0) found.push_back({q, no_cell});
        if (at_p * at_q < 0) found.push_back(edge_node(p, q));
    }
}

// In the facet that a cut edge makes with a vertex.
void SurfaceSection::add_across(const SectionNode& node, std::uint32_t r,
                                std::vector<SectionNode>& found) const {
    const int at_r = side(r);
    if (at_r == 0) return found.push_back({r, no_cell});
    found.push_back(edge_node(side(node.p) != at_r ? node.p : node.q, r));
}

}  // namespace anatomesh
