#include "anatomesh/pipeline/model/quadratic_model.h"

#include <chrono>

#include "anatomesh/improve/operations/segment_edges.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"

namespace anatomesh {

namespace {

// Contour segments as pairs of the model's vertices.
std::vector<VertexPair> segments_of(const Model& model, const ContourSet& contours) {
    std::vector<VertexPair> segments;
    segments.reserve(contours.points.size());
    for (const Contour& contour : contours.contours) {
        for (std::uint32_t n = 0; n < contour.point_count; ++n) {
            segments.push_back({model.contour_vertices[contour.first_point + n],
                                model.contour_vertices[contour.first_point + (n + 1) % contour.point_count]});
        }
    }
    return segments;
}

}  // namespace

Result<MidNodes> quadratic_model(Model& model, const ContourSet& contours, const QuadraticOptions& options,
                                 RunContext& context) {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<VertexPair> segment_edges =
        edges_along(model.mesh, cell_neighbors(model.mesh.cells, model.mesh.points.size(), context.threads),
                    segments_of(model, contours));
    ANATOMESH_TRY(QuadraticResult result,
                  quadratic_elements(model.mesh, model.regions, {*model.field, model.field_origin},
                                     segment_edges, options, context));
    const QuadraticStats& stats = result.stats;
    StageReport stage;
    stage.name = "element";
    stage.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    stage.points = model.mesh.points.size() + result.mid_nodes.points.size();
    stage.cells = model.mesh.cells.size();
    stage.figures = {{"mid_nodes", static_cast<double>(stats.nodes)},
                     {"interface_nodes", static_cast<double>(stats.interface_nodes)},
                     {"segment_nodes", static_cast<double>(stats.segment_nodes)},
                     {"junction_nodes", static_cast<double>(stats.junction_nodes)},
                     {"out_of_reach", static_cast<double>(stats.out_of_reach)},
                     {"on_interface", static_cast<double>(stats.on_interface)},
                     {"pulled_back", static_cast<double>(stats.pulled_back)},
                     {"straightened", static_cast<double>(stats.straightened)},
                     {"largest_offset_mm", stats.largest_offset_mm},
                     {"least_jacobian", stats.least_jacobian},
                     {"volume_mm3", stats.volume_mm3}};
    model.report.run.stages.push_back(std::move(stage));
    return std::move(result.mid_nodes);
}

}  // namespace anatomesh
