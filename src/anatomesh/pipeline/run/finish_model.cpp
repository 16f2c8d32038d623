#include "anatomesh/pipeline/run/finish_model.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "anatomesh/improve/reroute/routed_contours.h"
#include "anatomesh/improve/reroute/snap_round_segments.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/mesh/edit/drop_outside.h"
#include "anatomesh/pipeline/model/model_warnings.h"

namespace anatomesh {

namespace {

// By the vertices that are left; with one that was lost, a contour stays as it is drawn.
void renumber_routed(const std::vector<std::uint32_t>& vertex, std::vector<RoutedContour>& routed) {
    std::erase_if(routed, [&](RoutedContour& contour) {
        for (std::uint32_t& v : contour.vertices) v = vertex[v];
        return std::find(contour.vertices.begin(), contour.vertices.end(), no_cell) != contour.vertices.end();
    });
}

// Where all that was done left segments that are no edges of the surface.
void snap_round_beside(const PreparedRun& run, const ImproveInput& input,
                       const std::vector<std::uint32_t>& contour_vertices, const WorkingMesh& working,
                       RoutedRun& routed, const Model& model, int threads) {
    const double most_mm =
        most_reroute_mm(input.options, run.effort.improvement.most_snapped_sizes, input.sample.size_mm);
    if (routed.segments_missed == 0 || !(most_mm > 0)) return;
    const std::vector<RoutedContour> before = routed.contours;
    routed.contours = snap_round_segments(model.mesh, working.neighbors, model.regions, input.source,
                                          contour_vertices, std::move(routed.contours), {most_mm, threads});
    routed.has_segments_beside = routed.contours != before;
}

}  // namespace

void finish_model(const PreparedRun& run, const ImproveInput& input, WorkingMesh& working, RoutedRun& routed,
                  Model& model, int threads) {
    const ContourSet& source = input.source;
    model.mesh = std::move(working.mesh);
    working.mesh = {};
    model.regions = std::move(working.regions);
    TetMesh& mesh = model.mesh;
    const std::vector<std::uint32_t> vertex = drop_outside(mesh, working.neighbors, threads);
    std::vector<std::uint32_t> contour_vertices = input.growing.contour_vertices;
    for (std::uint32_t& v : contour_vertices) v = vertex[v];
    renumber_routed(vertex, routed.contours);
    compact_regions(mesh, model.regions);
    move_back(run.origin, mesh.points);
    for (std::size_t n = 0; n < contour_vertices.size(); ++n) {
        const std::uint32_t v = contour_vertices[n];
        // One that was lost is the certificate's to find.
        if (v != no_cell) mesh.points[v] = source.points[n];
    }
    snap_round_beside(run, input, contour_vertices, working, routed, model, threads);
    ContoursOfMesh kept = route_contours(source, contour_vertices, routed.contours, mesh.points);
    model.contours = std::move(kept.contours);
    model.contour_vertices = std::move(kept.vertices);
    model.report.contours.routed =
        routed_contour_reports(source, contour_vertices, routed.contours, mesh.points);
    model.routed = std::move(routed.contours);
    model.structures = run.contours.structures;
    model.field = run.known.field;
    model.field_origin = run.origin;
}

void measure_run(const PreparedRun& run, const ContourSet& source, const RunContext& context, Model& model) {
    const std::vector<double> volumes_mm3 = volumes_by_field(run.known.volumes);
    CertificateInput input{model.mesh, model.regions, model.structures};
    input.contours = &source;
    if (!model.routed.empty()) input.on_surface = &model.contours;
    input.field_volumes_mm3 = volumes_mm3;
    input.field = run.field.get();
    input.field_origin = run.origin;
    measure_model(input, context, model.report);
}

TopologyFindings warn_of_run(const PreparedRun& run, const Model& model,
                             const std::vector<std::uint32_t>& neighbors, RunContext& context) {
    const ContourSet& contours = run.contours;
    const double size_mm = model.report.lengths.size_mm;
    warn_of_model(model.report, size_mm, contours.source, context);
    warn_of_overlaps(model.mesh, model.regions, model.structures, contours.source, context);
    warn_of_volumes(run.known.volumes, model.structures, contours.exclusive, contours.source, context);
    // The clauses of the contract hold for a plate with holes as well.
    std::vector<std::size_t> same(run.structures);
    std::iota(same.begin(), same.end(), std::size_t{0});
    TopologyFindings tears = check_topology({model.mesh, neighbors, model.regions, model.report.structures,
                                             model.contours, same, model.contour_vertices, size_mm},
                                            context.threads);
    warn_of_topology(tears, model.contours, size_mm, context);
    // What was not done for their sake is the user's to know.
    if (run.effort.reduced) warn_of_constraint_limited_cells(model.report, contours.source, context);
    return tears;
}

Status judge_run(const PreparedRun& run, const ModelReport& report, bool size_given) {
    // Cuts, quality and volume are out of reach for this input; a wrong surface is a fault of ours, whatever else
    // came of it.
    const auto out_of_reach = [](const Clause& clause) {
        return clause.number == 2 || clause.number == 4 || clause.number == 6;
    };
    const Clause* broken = nullptr;
    for (const Clause& clause : report.certificate) {
        if (clause.state != ClauseState::broken) continue;
        if (!broken || (out_of_reach(*broken) && !out_of_reach(clause))) broken = &clause;
    }
    if (!broken) return Nothing{};
    return Error{out_of_reach(*broken) ? ErrorKind::geometry : ErrorKind::internal,
                 "E-PIP-002",
                 "clause " + std::to_string(broken->number) +
                     " of the certificate is broken: " + broken->statement + " (" + broken->evidence + ")",
                 {},
                 advice_on_size(mean_thickness(run.contours), report.lengths.size_mm, size_given) +
                     "; nothing was written"};
}

}  // namespace anatomesh
