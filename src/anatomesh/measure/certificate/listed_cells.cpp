#include "anatomesh/measure/certificate/listed_cells.h"

#include <numeric>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/measure/contour_fidelity.h"

namespace anatomesh {

ShapeFindings list_cells(const CertificateInput& input, const CellShapes& shapes,
                         const ContourFindings& findings, int threads, ModelReport& report) {
    report.listed_cells.cells.clear();
    report.listed_cells.total = shapes.over_bound.size();
    report.listed_cells.forced = report.listed_cells.bad = 0;
    ShapeFindings found;
    found.above = report.quality.radius_edge.over_2;
    found.mean_free = report.quality.radius_edge.mean;
    if (shapes.over_bound.empty()) return found;
    const ContourSet none;
    ForcedCells forced(input.mesh, input.contours ? *input.contours : none, findings.vertex_of);
    forced.find_constraint_limited(shapes.over_bound, contract::forcing_share * report.quality.edge_mm.mean);
    for (const std::uint32_t c : shapes.over_bound) {
        ListedCell listed{c, shapes.radius_edge[c], shapes.min_dihedral_deg[c], {}, forced.reason(c)};
        Vec3 sum;
        for (const std::uint32_t v : input.mesh.cells[c]) sum += input.mesh.points[v];
        listed.at = {sum.x / 4, sum.y / 4, sum.z / 4};
        const bool is_forced = !listed.forced_by.empty();
        report.listed_cells.forced += is_forced;
        found.forced += is_forced && listed.value > contract::max_radius_edge;
        // Negated, so that a ratio that is no number is bad.
        const bool bad = !(listed.value <= contract::bad_radius_edge) ||
                         listed.min_dihedral_deg < contract::bad_dihedral_degrees;
        const bool gross = !(listed.value <= contract::gross_radius_edge) ||
                           listed.min_dihedral_deg < contract::gross_dihedral_degrees;
        found.bad += bad && !is_forced;
        report.listed_cells.bad += bad && !is_forced;
        found.gross += gross && !is_forced;
        found.forced_gross += gross && is_forced;
        if ((is_forced ? gross : bad) && found.worst.size() < named_places) found.worst.push_back(listed);
        if (report.listed_cells.cells.size() < max_listed_cells)
            report.listed_cells.cells.push_back(std::move(listed));
    }
    if (input.contours) {
        // A thread takes so many cells at a time; sums of such pieces are added in order, so that they are
        // the same for any number of threads. [cells; >= 1; B]
        constexpr std::size_t grain = 16384;
        const std::size_t cells = shapes.radius_edge.size();
        std::vector<double> sums(cells / grain + 1, 0);
        std::vector<std::uint64_t> counts(sums.size(), 0);
        parallel_for(cells, grain, threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) {
                if (forced.forced(static_cast<std::uint32_t>(c))) continue;
                sums[begin / grain] += shapes.radius_edge[c];
                ++counts[begin / grain];
            }
        });
        const auto count = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
        found.mean_free =
            count > 0 ? std::accumulate(sums.begin(), sums.end(), 0.0) / static_cast<double>(count) : 0;
    }
    return found;
}

}  // namespace anatomesh
