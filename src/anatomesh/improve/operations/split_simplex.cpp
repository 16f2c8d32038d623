#include <algorithm>
#include <array>

#include "anatomesh/improve/core/hole.h"
#include "anatomesh/improve/operations/operations.h"

namespace anatomesh {

namespace {

constexpr std::array<double, 5> shares{0.5, 0.4, 0.6, 0.3, 0.7};  // of an edge, up to the new vertex
constexpr std::array<double, 4> heights{0.25, 0.4, 0.15, 0.55};   // over a cell, in its longest edges

// Across the largest facet of a cell, as long as the longest edge of that.
Vec3 across_largest_facet(const Workbench& bench, std::uint32_t cell) {
    Vec3 normal{};
    double longest = 0;
    for (const auto& f : facet_vertices) {
        const Cell& c = bench.mesh.cell(cell);
        const Vec3 p = bench.mesh.point(c[f[0]]), q = bench.mesh.point(c[f[1]]),
                   r = bench.mesh.point(c[f[2]]);
        const Vec3 n = cross(q - p, r - p);
        if (squared_length(n) <= squared_length(normal)) continue;
        normal = n;
        longest = std::max({length(q - p), length(r - q), length(p - r)});
    }
    return longest * normalized(normal);
}

}  // namespace

bool split_edge(Workbench& bench, std::uint32_t cell, int e) {
    if (!bench.mesh.edge_on_interface(cell, e)) return false;
    bench.mesh.ring(cell, e, bench.ring);
    if (!bench.ring.closed) return false;
    const std::uint32_t a = bench.ring.a, b = bench.ring.b;
    const bool fixed = bench.fixed_edge(a, b);
    const Vec3 from = bench.mesh.point(a), way = bench.mesh.point(b) - from;
    const auto better = [&](const Bar& bar) { return bench.needed_sine(bar); };
    const auto fill = [&](Hole hole) {
        for (const double share : shares) {
            Hole tried = hole;
            if (!tried.fill_from(from + share * way, bench.options.max_radius_edge, better)) continue;
            if (fixed) bench.fix_on_edge(static_cast<std::uint32_t>(bench.mesh.point_count() - 1), a, b);
            ++bench.stats.vertices_inserted;
            return true;
        }
        return false;
    };
    Hole hole(bench, bench.ring);
    if (fill(hole)) return true;
    // In a flat cell the opposite edge passes close to this one: where it stays, the cells with it are flat
    // too.
    EdgeRing opposite;
    bench.mesh.ring(cell, 5 - e, opposite);
    return hole.add(opposite) && fill(hole);
}

bool split_facet(Workbench& bench, std::uint32_t cell, int facet) {
    const std::uint32_t beyond = bench.mesh.neighbor(cell, facet);
    if (beyond == no_cell) return false;
    Vec3 middle{};
    for (const int n : facet_vertices[facet])
        middle = middle + (1.0 / 3) * bench.mesh.point(bench.mesh.cell(cell)[n]);
    const auto better = [&](const Bar& bar) { return bench.needed_sine(bar); };
    const double most = bench.options.max_radius_edge;
    Hole hole(bench, {cell, beyond}, {});
    const bool inside = bench.mesh.region(cell) == bench.mesh.region(beyond);
    const bool done = inside ? hole.fill(middle, {}, most, better, [](Vec3&) { return true; })
                             : hole.fill_from(middle, most, better);
    bench.stats.vertices_inserted += done;
    return done;
}

bool split_cell(Workbench& bench, std::uint32_t cell) {
    Hole hole(bench, {cell}, {});
    const auto better = [&](const Bar& bar) { return bench.needed_sine(bar); };
    const bool done =
        hole.fill(hole.centre(), {}, bench.options.max_radius_edge, better, [](Vec3&) { return true; });
    bench.stats.vertices_inserted += done;
    return done;
}

bool insert_beside(Workbench& bench, std::uint32_t cell) {
    const Vec3 across = across_largest_facet(bench, cell);
    Vec3 middle{};
    for (const std::uint32_t v : bench.mesh.cell(cell)) middle += 0.25 * bench.mesh.point(v);
    const auto better = [&](const Bar& bar) { return bench.needed_sine(bar); };
    const auto anywhere = [](Vec3&) { return true; };
    for (const double height : heights) {
        for (const double side : {1.0, -1.0}) {
            const Vec3 p = middle + (side * height) * across;
            // The hole grows to where the vertex is.
            if (!Hole(bench, {cell}, {}).fill(p, {}, bench.options.max_radius_edge, better, anywhere))
                continue;
            ++bench.stats.vertices_inserted;
            return true;
        }
    }
    return false;
}

}  // namespace anatomesh
