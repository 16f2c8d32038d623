#include "anatomesh/refine/refine.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "anatomesh/base/parallel.h"
#include "anatomesh/cull/cull.h"
#include "anatomesh/mesh/quality.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

namespace {

struct BadCell {
    std::uint32_t cell;
    double ratio, radius;
    std::optional<Vec3> point;
    bool on_surface = false;
};

double shortest_edge(const std::vector<Vec3>& points, const Cell& cell) {
    double squared = squared_length(points[cell[0]] - points[cell[1]]);
    for (const auto& [i, j] : cell_edges) squared = std::min(squared, squared_length(points[cell[i]] - points[cell[j]]));
    return std::sqrt(squared);
}

// Where to put a point that takes the cell away.
void choose_point(const std::vector<Vec3>& points, const Cell& cell, InterfaceProbe& probe, const PointGrid& all_points,
                  const RefineOptions& options, BadCell& bad) {
    const Vec3 a = points[cell[0]], b = points[cell[1]], c = points[cell[2]], d = points[cell[3]];
    const double shortest = shortest_edge(points, cell);
    const Vec3 center = circumcenter(a, b, c, d), centroid = 0.25 * (a + b + c + d);
    bad.radius = length(center - a);
    const double tolerance = 1e-3 * shortest;
    // The interface between the cell and its circumcentre, or close to that.
    std::optional<Vec3> on_surface = probe.first_crossing(centroid, center, 0.5 * shortest, tolerance);
    if (!on_surface && probe.distance(center) < options.surface_pull * bad.radius) {
        on_surface = probe.project(center, options.surface_pull * bad.radius, tolerance);
    }
    if (on_surface && !all_points.any_within(*on_surface, options.min_spacing * shortest)) {
        bad.point = on_surface;
        bad.on_surface = true;
    } else if (!on_surface) {
        bad.point = center;
    }
}

}  // namespace

RefineStats find_refinement_points(const std::vector<Vec3>& points, const DelaunaySnapshot& mesh,
                                   const std::vector<Region>& regions, const StructureField& field,
                                   std::uint32_t structures, const PointGrid& all_points, const RefineOptions& options,
                                   std::vector<Vec3>& found, RunContext& context) {
    RefineStats stats;
    std::vector<BadCell> bad;
    std::uint64_t inside = 0;
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        if (regions[c] == 0) continue;
        const Cell& cell = mesh.cells[c];
        const double ratio = radius_edge_ratio(points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]);
        ++inside;
        stats.radius_edge_mean += std::isfinite(ratio) ? ratio : 0;
        if (ratio > options.max_radius_edge) bad.push_back({c, ratio, 0, std::nullopt});
    }
    stats.radius_edge_mean /= std::max<std::uint64_t>(1, inside);
    stats.above_bound = bad.size();

    parallel_for(bad.size(), 256, context.threads, [&](std::size_t first, std::size_t last) {
        InterfaceProbe probe(field, structures);
        for (std::size_t n = first; n < last; ++n) {
            choose_point(points, mesh.cells[bad[n].cell], probe, all_points, options, bad[n]);
        }
    });
    // Worst first; one point for each neighbourhood a round.
    std::stable_sort(bad.begin(), bad.end(), [](const BadCell& a, const BadCell& b) { return a.ratio > b.ratio; });
    double reach = 0;
    for (const BadCell& cell : bad) reach += cell.radius;
    PointGrid chosen(bad.empty() ? 1.0 : std::max(1e-300, reach / static_cast<double>(bad.size())), bad.size());
    for (const BadCell& cell : bad) {
        if (!cell.point) {
            ++stats.refused;
            continue;
        }
        if (chosen.any_within(*cell.point, 0.7 * cell.radius)) continue;
        chosen.add(*cell.point);
        found.push_back(*cell.point);
        ++(cell.on_surface ? stats.surface_points : stats.circumcenters);
    }
    return stats;
}

CrossingStats find_crossing_points(const std::vector<Vec3>& points, const DelaunaySnapshot& mesh,
                                   const std::vector<Region>& sides, const StructureField& field,
                                   std::uint32_t structures, const PointGrid& all_points, double min_spacing,
                                   std::vector<Vec3>& found, RunContext& context) {
    CrossingStats stats;
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (const Cell& cell : mesh.cells) {
        for (const auto& [i, j] : cell_edges) {
            const std::uint32_t a = std::min(cell[i], cell[j]), b = std::max(cell[i], cell[j]);
            if (sides[a] != sides[b] && sides[a] != on_interface && sides[b] != on_interface) edges.push_back({a, b});
        }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    stats.crossing_edges = edges.size();

    std::vector<std::optional<Vec3>> crossings(edges.size());
    parallel_for(edges.size(), 256, context.threads, [&](std::size_t first, std::size_t last) {
        InterfaceProbe probe(field, structures);
        for (std::size_t n = first; n < last; ++n) {
            const Vec3 p = points[edges[n][0]], q = points[edges[n][1]];
            const double span = length(q - p);
            const std::optional<Vec3> crossing = probe.first_crossing(p, q, 0.25 * span, 1e-3 * span);
            if (crossing && !all_points.any_within(*crossing, min_spacing * span)) crossings[n] = crossing;
        }
    });
    double total = 0;
    for (const auto& [a, b] : edges) total += length(points[b] - points[a]);
    PointGrid chosen(edges.empty() ? 1.0 : total / static_cast<double>(edges.size()), edges.size());
    for (std::size_t n = 0; n < edges.size(); ++n) {
        if (!crossings[n]) {
            ++stats.refused;
            continue;
        }
        const double span = length(points[edges[n][1]] - points[edges[n][0]]);
        if (chosen.any_within(*crossings[n], 0.5 * span)) continue;
        chosen.add(*crossings[n]);
        found.push_back(*crossings[n]);
    }
    return stats;
}

}  // namespace anatomesh
