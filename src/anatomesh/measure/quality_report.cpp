#include "anatomesh/measure/quality_report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

constexpr double radius_edge_bound = contract::max_radius_edge,
                 listed_angle_deg = contract::bad_dihedral_degrees;

struct Edges {
    double shortest, longest, sum;
};

Edges edges_of(const std::array<Vec3, 4>& p) {
    Edges edges{std::numeric_limits<double>::infinity(), 0, 0};
    for (const auto& [i, j] : cell_edges) {
        const double edge = length(p[static_cast<std::size_t>(j)] - p[static_cast<std::size_t>(i)]);
        edges.shortest = std::min(edges.shortest, edge);
        edges.longest = std::max(edges.longest, edge);
        edges.sum += edge;
    }
    return edges;
}

double percentile(std::vector<double>& values, double share) {
    const double rank = std::ceil(share * static_cast<double>(values.size()));
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

Histogram histogram(const std::vector<double>& values, double low, double high, std::size_t bins) {
    Histogram result{low, high, std::vector<std::uint64_t>(bins, 0)};
    const double per_unit = static_cast<double>(bins) / (high - low);
    for (const double value : values) {
        const double bin = std::clamp((value - low) * per_unit, 0.0, static_cast<double>(bins - 1));
        ++result.counts[static_cast<std::size_t>(bin)];
    }
    return result;
}

}  // namespace

CellShapes measure_shapes(const TetMesh& mesh, const RunContext& context) {
    CellShapes shapes;
    QualityReport& report = shapes.report;
    const std::size_t count = mesh.cells.size();
    if (count == 0) return shapes;
    std::vector<double> ratio(count), smallest(count), largest(count);
    std::vector<Edges> edges(count);
    parallel_for(count, 16384, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            std::array<Vec3, 4> p;
            for (std::size_t i = 0; i < 4; ++i) p[i] = mesh.points[mesh.cells[c][i]];
            ratio[c] = radius_edge_ratio(p[0], p[1], p[2], p[3]);
            const DihedralRange range = dihedral_range(p[0], p[1], p[2], p[3]);
            smallest[c] = range.smallest;
            largest[c] = range.largest;
            edges[c] = edges_of(p);
        }
    });

    double ratio_sum = 0, edge_sum = 0;
    report.edge_mm.min = edges[0].shortest;
    for (std::size_t c = 0; c < count; ++c) {
        ratio_sum += ratio[c];
        edge_sum += edges[c].sum;
        report.edge_mm.min = std::min(report.edge_mm.min, edges[c].shortest);
        report.edge_mm.max = std::max(report.edge_mm.max, edges[c].longest);
        report.dihedral_deg.max = std::max(report.dihedral_deg.max, largest[c]);
        report.dihedral_deg.below_10 += smallest[c] < 10.0;
        report.dihedral_deg.below_15 += smallest[c] < 15.0;
        const bool over = ratio[c] > radius_edge_bound;
        report.radius_edge.over_2 += over;
        if (over || smallest[c] < listed_angle_deg)
            shapes.over_bound.push_back(static_cast<std::uint32_t>(c));
    }
    std::sort(shapes.over_bound.begin(), shapes.over_bound.end(), [&](std::uint32_t a, std::uint32_t b) {
        const bool over_a = ratio[a] > radius_edge_bound, over_b = ratio[b] > radius_edge_bound;
        if (over_a != over_b) return over_a;
        if (over_a && ratio[a] != ratio[b]) return ratio[a] > ratio[b];
        if (!over_a && smallest[a] != smallest[b]) return smallest[a] < smallest[b];
        return a < b;
    });
    const auto cells = static_cast<double>(count);
    report.radius_edge.mean = ratio_sum / cells;
    report.radius_edge.share_over_2 = static_cast<double>(report.radius_edge.over_2) / cells;
    report.edge_mm.mean = edge_sum / (6 * cells);
    report.radius_edge.histogram = histogram(ratio, 0.5, 3.0, 50);
    report.dihedral_deg.histogram = histogram(smallest, 0.0, 75.0, 75);

    shapes.min_dihedral_deg = smallest;  // percentile() puts them into another order
    report.dihedral_deg.min = *std::min_element(smallest.begin(), smallest.end());
    report.dihedral_deg.p01 = percentile(smallest, 0.01);
    report.dihedral_deg.median_min = percentile(smallest, 0.5);
    shapes.radius_edge = ratio;
    report.radius_edge.max = *std::max_element(ratio.begin(), ratio.end());
    report.radius_edge.p99 = percentile(ratio, 0.99);
    return shapes;
}

}  // namespace anatomesh
