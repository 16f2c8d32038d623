#include "anatomesh/measure/certificate/certificate.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "anatomesh/base/parallel.h"
#include "anatomesh/measure/certificate/clauses.h"
#include "anatomesh/measure/certificate/contour_reports.h"
#include "anatomesh/measure/certificate/listed_cells.h"
#include "anatomesh/measure/certificate/structure_reports.h"
#include "anatomesh/measure/field_difference.h"
#include "anatomesh/measure/field_distance.h"
#include "anatomesh/measure/quality_report.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/check/validity.h"

namespace anatomesh {

namespace {

// The contours' structure of each of the model's; without contours the field's are the model's.
std::vector<std::uint32_t> structures_of_field(const CertificateInput& input) {
    std::vector<std::uint32_t> of_field(input.structures.size(), no_cell);
    if (!input.contours) {
        std::iota(of_field.begin(), of_field.end(), 0U);
        return of_field;
    }
    for (std::uint32_t s = 0; s < input.contours->structures.size(); ++s) {
        const std::size_t match = matching_structure(input.contours->structures, s, input.structures);
        if (match < of_field.size()) of_field[match] = s;
    }
    return of_field;
}

// Nothing can be measured on a mesh with an index beyond its points, or a point that is not finite.
bool can_be_measured(const TetMesh& mesh) {
    return std::all_of(
               mesh.points.begin(), mesh.points.end(),
               [](Vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }) &&
           std::all_of(mesh.cells.begin(), mesh.cells.end(), [&](const Cell& cell) {
               return *std::max_element(cell.begin(), cell.end()) < mesh.points.size();
           });
}

}  // namespace

std::size_t matching_structure(std::span<const Structure> contours, std::size_t structure,
                               std::span<const Structure> model) {
    if (contours.size() == 1 && model.size() == 1) return 0;
    const auto found = std::find_if(model.begin(), model.end(), [&](const Structure& other) {
        return other.number == contours[structure].number;
    });
    return static_cast<std::size_t>(found - model.begin());
}

void measure_model(const CertificateInput& input, const RunContext& context, ModelReport& report) {
    const TetMesh& mesh = input.mesh;
    assert(mesh.regions.size() == mesh.cells.size());
    assert(input.field_volumes_mm3.empty() || input.field_volumes_mm3.size() == input.structures.size());

    MeshCheck check;
    ContourFindings findings;
    CellShapes shapes;
    const bool measurable = can_be_measured(mesh);
    std::vector<std::uint32_t> neighbors;
    check = check_mesh(mesh, context.threads, &neighbors);
    Surfaces surfaces;
    const auto compare_with_field = [&] {
        if (!input.field) return;
        const std::vector<std::uint32_t> of_field = structures_of_field(input);
        report.field.distance =
            farthest_from_field(mesh, neighbors, input.regions, input.structures, of_field, *input.field,
                                input.field_origin, context.threads);
        report.field.difference = field_difference(mesh.points, surfaces, input.structures, of_field,
                                                   *input.field, input.field_origin, context.threads);
    };
    // Much of this is serial: the field, which is not, is asked beside it.
    const auto measure_surfaces = [&] {
        const ShellNumbers shells = measure_structures(input, surfaces, neighbors, context.threads, report);
        if (input.contours) findings = measure_contours(input, surfaces, shells, report);
    };
    if (measurable) {
        for (std::uint32_t s = 0; s < input.structures.size(); ++s) {
            surfaces.push_back(structure_surface(mesh, neighbors, input.regions, s, context.threads));
        }
        report.counts.surface_triangles = count_interface_facets(mesh, neighbors, context.threads);
        parallel_tasks(context.threads, {compare_with_field, measure_surfaces,
                                         [&] { shapes = measure_shapes(mesh, context); }});
    }
    report.counts.vertices = mesh.points.size();
    report.counts.tetrahedra = mesh.cells.size();
    report.certificate.clear();
    if (!measurable) {
        report.certificate.push_back(clause_validity(check, report));
        report.certificate.back().state = ClauseState::broken;
        return;
    }
    report.quality = shapes.report;
    const ShapeFindings shape = list_cells(input, shapes, findings, context.threads, report);

    report.certificate = {clause_vertices(input, findings.all, context),
                          clause_segments(input, findings, report),
                          clause_validity(check, report),
                          clause_shape(input, shape, report),
                          clause_determinism(input),
                          clause_volume(input, report)};
}

bool any_broken(std::span<const Clause> certificate) {
    return std::any_of(certificate.begin(), certificate.end(),
                       [](const Clause& clause) { return clause.state == ClauseState::broken; });
}

}  // namespace anatomesh
