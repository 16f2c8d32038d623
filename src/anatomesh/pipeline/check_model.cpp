#include "anatomesh/pipeline/check_model.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "anatomesh/base/plural.h"
#include "anatomesh/base/standard_arithmetic.h"
#include "anatomesh/element/quadratic.h"
#include "anatomesh/measure/contour_fidelity.h"
#include "anatomesh/measure/topology/topology_warnings.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/pipeline/model/model_warnings.h"

namespace anatomesh {

namespace {

bool are_closed(const ModelReport& report) {
    return std::none_of(report.certificate.begin(), report.certificate.end(), [](const Clause& clause) {
        return clause.number == 3 && clause.state == ClauseState::broken;
    });
}

// Of surfaces that are closed: of others nothing can be said.
void look_for_tears(const CertificateInput& model, const ModelReport& report, double size_mm,
                    RunContext& context) {
    if (report.structures.empty() || !are_closed(report)) return;
    const TetMesh& mesh = model.mesh;
    const ContourSet& contours = model.on_surface ? *model.on_surface : *model.contours;
    const std::vector<std::uint32_t> neighbors =
        cell_neighbors(mesh.cells, mesh.points.size(), context.threads);
    std::vector<std::size_t> structure_of;
    std::vector<std::vector<Triangle>> surfaces(contours.structures.size());
    for (std::uint32_t s = 0; s < surfaces.size(); ++s) {
        structure_of.push_back(matching_structure(contours.structures, s, model.structures));
        if (structure_of[s] < report.structures.size())
            surfaces[s] = structure_surface(mesh, neighbors, model.regions,
                                            static_cast<std::uint32_t>(structure_of[s]), context.threads);
    }
    const std::vector<std::uint32_t> vertex_of = contour_fidelity(mesh.points, surfaces, contours).vertex_of;
    const TopologyFindings tears = check_topology(
        {mesh, neighbors, model.regions, report.structures, contours, structure_of, vertex_of, size_mm},
        context.threads);
    warn_of_topology(tears, contours, size_mm, context);
}

// The contract is about the elements with straight edges: folded ones are warned of.
void look_at_jacobians(const TetMesh& mesh, const MidNodes& mid_nodes, const std::string& file,
                       RunContext& context) {
    std::uint64_t bad = 0, first = 0;
    for (std::size_t c = 0; c < mid_nodes.cells.size(); ++c) {
        if (least_jacobian(element_of(mesh, mid_nodes, c)) > 0) continue;
        if (bad++ == 0) first = c + 1;
    }
    if (bad == 0) return;
    context.warn(
        {"W-ELM-002",
         counted(bad, "quadratic element has", "quadratic elements have") +
             " a Jacobian that may not be positive everywhere, so that a solver may refuse the model",
         {file, "", "", "", "element " + std::to_string(first)},
         "they were kept"});
}

}  // namespace

void check_model(const CertificateInput& model, const CheckModelOptions& options, RunContext& context,
                 ModelReport& report) {
    const StandardArithmetic arithmetic;
    measure_model(model, context, report);
    report.lengths.size_mm = options.size_mm;
    const double size_mm = report.lengths.size_mm > 0 ? report.lengths.size_mm : report.quality.edge_mm.mean;
    warn_of_model(report, size_mm, options.contours_file, context);
    if (model.contours) look_for_tears(model, report, size_mm, context);
    if (options.mid_nodes) look_at_jacobians(model.mesh, *options.mid_nodes, options.model_file, context);
}

}  // namespace anatomesh
