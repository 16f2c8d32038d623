#include "anatomesh/cut/cut_spindles.h"

#include <algorithm>
#include <array>
#include <optional>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

using Edge = std::array<std::uint32_t, 2>;

// The cells round an edge in order, with the ring vertex before each: ring[n], ring[n + 1] belong to cells[n].
struct Ring {
    std::vector<std::uint32_t> cells, vertices;
    bool closed = false;
};

Ring ring_of(const NonmanifoldPatch& patch, std::uint32_t first, Edge edge) {
    Ring ring;
    // The two other vertices of the first cell, so ordered that (a, b, c, d) is positive.
    const auto others = [&](std::uint32_t c) {
        std::array<std::uint32_t, 2> rest{};
        std::array<std::uint32_t, 4> order{edge[0], edge[1], 0, 0};
        int n = 0;
        for (const std::uint32_t v : patch.cells[c]) {
            if (v != edge[0] && v != edge[1]) rest[n++] = v;
        }
        order[2] = rest[0];
        order[3] = rest[1];
        if (!(orient3d(patch.points[order[0]], patch.points[order[1]], patch.points[order[2]],
                       patch.points[order[3]]) > 0))
            std::swap(rest[0], rest[1]);
        return rest;
    };
    std::uint32_t c = first;
    do {
        const auto rest = others(c);
        ring.cells.push_back(c);
        ring.vertices.push_back(rest[0]);
        // Across the facet (a, b, rest[1]), opposite rest[0].
        const auto at =
            std::find(patch.cells[c].begin(), patch.cells[c].end(), rest[0]) - patch.cells[c].begin();
        c = patch.neighbors[c][at];
    } while (c != no_cell && c != first);
    ring.closed = c == first;
    return ring;
}

// A maximal run of a ring's cells on one side of a body: `count` cells from `begin` on, round the end.
struct Arc {
    std::size_t begin, count;
    Region region = 0;  // of the cell before it
};

std::vector<Arc> arcs_of(const NonmanifoldPatch& patch, const Ring& ring, Body body) {
    const std::size_t n = ring.cells.size();
    const auto inside = [&](std::size_t k) {
        return body.holds(patch.table(), patch.regions[ring.cells[k % n]]);
    };
    std::vector<Arc> arcs;
    for (std::size_t k = 0; k < n; ++k) {
        if (inside(k) == inside(k + n - 1)) continue;
        std::size_t count = 1;
        while (inside(k + count) == inside(k)) ++count;
        arcs.push_back({k, count, patch.regions[ring.cells[(k + n - 1) % n]]});
    }
    return arcs;
}

// The regions of the cells, then their structures.
std::vector<Body> bodies_of(const NonmanifoldPatch& patch, const std::vector<std::uint32_t>& cells) {
    std::vector<std::uint32_t> regions, structures;
    for (const std::uint32_t c : cells) {
        regions.push_back(patch.regions[c]);
        const auto& members = patch.table().members[patch.regions[c]];
        structures.insert(structures.end(), members.begin(), members.end());
    }
    std::vector<Body> bodies;
    for (auto* list : {&regions, &structures}) {
        std::sort(list->begin(), list->end());
        list->erase(std::unique(list->begin(), list->end()), list->end());
        for (const std::uint32_t index : *list) bodies.push_back({list == &regions, index});
    }
    return bodies;
}

// The shortest arc of the first body that the ring has in four arcs or more, or none.
std::optional<Arc> surplus_arc(const NonmanifoldPatch& patch, const Ring& ring) {
    for (const Body body : bodies_of(patch, ring.cells)) {
        const std::vector<Arc> arcs = arcs_of(patch, ring, body);
        if (arcs.size() < 4) continue;
        return *std::min_element(arcs.begin(), arcs.end(), [](const Arc& a, const Arc& b) {
            return a.count != b.count ? a.count < b.count : a.begin < b.begin;
        });
    }
    return std::nullopt;
}

// The spindle's points are appended to the patch's, and taken back if its cells do not fit.
bool cut_spindle(NonmanifoldPatch& patch, Edge edge, const Ring& ring, const Arc& arc, double reach,
                 PatchChange& change) {
    const std::size_t n = ring.cells.size();
    const Vec3 middle = 0.5 * (patch.points[edge[0]] + patch.points[edge[1]]);
    const std::uint32_t first_new = static_cast<std::uint32_t>(patch.points.size());
    for (const std::uint32_t v : ring.vertices) {
        patch.points.push_back(middle + reach * (patch.points[v] - middle));
    }
    LabelledCells added;
    for (std::size_t k = 0; k < n; ++k) {
        const std::uint32_t c = ring.vertices[k], d = ring.vertices[(k + 1) % n];
        const std::uint32_t p = first_new + static_cast<std::uint32_t>(k);
        const std::uint32_t q = first_new + static_cast<std::uint32_t>((k + 1) % n);
        const Region outer = patch.regions[ring.cells[k]];
        const bool in_arc = (k + n - arc.begin) % n < arc.count;
        added.add({edge[0], edge[1], p, q}, in_arc ? arc.region : outer);
        // The two pyramids over (p, q, d, c) share one diagonal.
        const bool from_p = p < q;
        const std::array<std::array<std::uint32_t, 3>, 2> halves =
            from_p ? std::array<std::array<std::uint32_t, 3>, 2>{{{p, d, q}, {p, c, d}}}
                   : std::array<std::array<std::uint32_t, 3>, 2>{{{q, p, c}, {q, c, d}}};
        for (const auto& [x, y, z] : halves) {
            added.add({edge[0], x, y, z}, outer);
            added.add({edge[1], x, y, z}, outer);
        }
    }
    if (!fits(patch, ring.cells, added)) {
        patch.points.resize(first_new);
        return false;
    }
    change.replace(patch, ring.cells, added, first_new);
    return true;
}

bool split_edge(NonmanifoldPatch& patch, const PatchStars& stars, Edge edge, double reach,
                PatchChange& change) {
    const auto star = stars.stars.at(edge[0]);
    const auto first = std::find_if(star.begin(), star.end(), [&](std::uint32_t c) {
        const Cell& cell = patch.cells[c];
        return std::find(cell.begin(), cell.end(), edge[1]) != cell.end();
    });
    if (first == star.end()) return false;
    const Ring ring = ring_of(patch, *first, edge);
    if (!ring.closed || change.touches(ring.cells)) return false;
    const std::optional<Arc> arc = surplus_arc(patch, ring);
    return arc && cut_spindle(patch, edge, ring, *arc, reach, change);
}

}  // namespace

std::uint64_t cut_spindles(NonmanifoldPatch& patch, const PatchStars& stars, double reach,
                           PatchChange& change) {
    std::vector<Edge> edges;
    for (const std::uint32_t v : stars.nonmanifold) {
        for (const std::uint32_t c : stars.stars.at(v)) {
            for (const std::uint32_t w : patch.cells[c]) {
                if (w != v) edges.push_back({std::min(v, w), std::max(v, w)});
            }
        }
    }
    sort_distinct(edges);
    std::uint64_t split = 0;
    for (const Edge& edge : edges) split += split_edge(patch, stars, edge, reach, change);
    return split;
}

}  // namespace anatomesh
