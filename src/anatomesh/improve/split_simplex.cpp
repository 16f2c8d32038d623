#include <algorithm>
#include <array>

#include "anatomesh/improve/hole.h"
#include "anatomesh/improve/operations.h"

namespace anatomesh {

namespace {

constexpr std::array<double, 5> shares{0.5, 0.4, 0.6, 0.3, 0.7};  // of an edge, up to the new vertex

}  // namespace

bool split_edge(Workbench& bench, std::uint32_t cell, int e) {
    if (!bench.mesh.edge_on_interface(cell, e)) return false;
    bench.mesh.ring(cell, e, bench.ring);
    if (!bench.ring.closed) return false;
    const std::uint32_t a = bench.ring.a, b = bench.ring.b;
    const bool fixed = bench.fixed_edge(a, b);
    const Vec3 from = bench.mesh.point(a), way = bench.mesh.point(b) - from;
    for (const double share : shares) {
        const auto better = [&](const Bar& bar) { return bench.needed_sine(bar); };
        if (!Hole(bench, bench.ring).fill_from(from + share * way, bench.options.max_radius_edge, better))
            continue;
        if (fixed) bench.fix_on_edge(static_cast<std::uint32_t>(bench.mesh.point_count() - 1), a, b);
        ++bench.stats.vertices_inserted;
        return true;
    }
    return false;
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

}  // namespace anatomesh
