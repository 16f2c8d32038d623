#include "anatomesh/measure/certificate.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <numeric>

#include "anatomesh/base/parallel.h"
#include "anatomesh/measure/contour_fidelity.h"
#include "anatomesh/measure/number_text.h"
#include "anatomesh/measure/quality_report.h"
#include "anatomesh/measure/slice_cuts.h"
#include "anatomesh/measure/volume.h"
#include "anatomesh/mesh/topology.h"
#include "anatomesh/mesh/validity.h"

namespace anatomesh {

namespace {

using Surfaces = std::vector<std::vector<Triangle>>;  // by structure

// "1 structure", "2 structures".
std::string counted(std::uint64_t count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string count_of(std::uint64_t part, std::uint64_t total) {
    return std::to_string(part) + " of " + std::to_string(total);
}

double surface_area(const std::vector<Vec3>& points, const std::vector<Triangle>& surface) {
    double twice = 0;
    for (const Triangle& f : surface) {
        twice += length(cross(points[f[1]] - points[f[0]], points[f[2]] - points[f[0]]));
    }
    return twice / 2;
}

void measure_structures(const CertificateInput& input, const Surfaces& surfaces,
                        std::span<const std::uint32_t> neighbors, ModelReport& report) {
    const TetMesh& mesh = input.mesh;
    const std::vector<double> volumes = mesh_volumes(mesh, input.regions, input.structures.size());
    std::vector<std::uint64_t> cells_of_region(input.regions.members.size(), 0);
    for (const Region region : mesh.regions) ++cells_of_region[region];
    report.structures.clear();
    for (std::uint32_t s = 0; s < input.structures.size(); ++s) {
        const SurfaceTopology topology = surface_topology(surfaces[s]);
        StructureReport structure;
        structure.number = input.structures[s].number;
        structure.name = input.structures[s].name;
        structure.color = input.structures[s].color;
        for (std::size_t r = 0; r < cells_of_region.size(); ++r) {
            if (input.regions.contains(static_cast<Region>(r), s)) structure.tetrahedra += cells_of_region[r];
        }
        structure.surface_triangles = topology.triangles;
        structure.surface_vertices = topology.vertices;
        structure.volume_mesh_mm3 = volumes[s];
        if (!input.field_volumes_mm3.empty()) structure.volume_field_mm3 = input.field_volumes_mm3[s];
        structure.area_mm2 = surface_area(mesh.points, surfaces[s]);
        structure.components = topology.components;
        structure.pieces = structure_pieces(mesh, neighbors, input.regions, s);
        structure.genus = topology.genus;
        structure.open_edges = topology.open_edges;
        structure.nonmanifold_edges = topology.nonmanifold_edges + topology.misoriented_edges;
        structure.nonmanifold_vertices = topology.nonmanifold_vertices;
        report.structures.push_back(std::move(structure));
    }
    report.regions = input.regions.members;
}

std::uint64_t count_interface_facets(const TetMesh& mesh, std::span<const std::uint32_t> neighbors) {
    std::uint64_t count = 0;
    for (std::size_t facet = 0; facet < neighbors.size(); ++facet) {
        const std::uint32_t other = neighbors[facet];
        count += mesh.regions[facet / 4] > (other == no_cell ? Region{0} : mesh.regions[other]);
    }
    return count;
}

// The model's structure that a contour structure is, or structures.size() when it has none.
std::size_t matching_structure(const CertificateInput& input, std::uint32_t contour_structure) {
    if (input.contours->structures.size() == 1 && input.structures.size() == 1) return 0;
    const std::int32_t number = input.contours->structures[contour_structure].number;
    const auto found = std::find_if(input.structures.begin(), input.structures.end(),
                                    [&](const Structure& structure) { return structure.number == number; });
    return static_cast<std::size_t>(found - input.structures.begin());
}

// Counts of contour vertices and segments on the surfaces; the vertex of every contour point.
struct ContourFindings {
    StructureFidelity all;
    std::vector<std::uint32_t> vertex_of;
};

ContourFindings measure_contours(const CertificateInput& input, const Surfaces& surfaces,
                                 ModelReport& report) {
    const ContourSet& contours = *input.contours;
    report.slices = contours.slices.size();
    report.contours = contours.contours.size();
    report.contour_vertices = contours.points.size();
    report.slice_spacing_mm = median_spacing(contours);
    Surfaces of_contours(contours.structures.size());
    std::vector<std::size_t> match(contours.structures.size());
    for (std::uint32_t s = 0; s < match.size(); ++s) {
        match[s] = matching_structure(input, s);
        if (match[s] < surfaces.size()) of_contours[s] = surfaces[match[s]];
    }
    ContourFidelity fidelity = contour_fidelity(input.mesh.points, of_contours, contours);
    const std::vector<double> volumes = slice_volumes(contours);
    ContourFindings findings;
    for (std::size_t s = 0; s < match.size(); ++s) {
        const StructureFidelity& part = fidelity.structures[s];
        findings.all.vertices += part.vertices;
        findings.all.vertices_on_surface += part.vertices_on_surface;
        findings.all.segments += part.segments;
        findings.all.segments_on_surface += part.segments_on_surface;
        if (match[s] >= report.structures.size()) continue;
        StructureReport& structure = report.structures[match[s]];
        structure.contour_vertices += part.vertices;
        structure.contour_vertices_on_surface += part.vertices_on_surface;
        structure.contour_segments += part.segments;
        structure.contour_segments_on_surface += part.segments_on_surface;
        if (!volumes.empty()) structure.volume_slices_mm3 += volumes[s];
    }
    report.cuts.clear();
    for (const SliceCut& cut : slice_cuts(input.mesh.points, of_contours, contours, fidelity.vertex_of)) {
        const Structure& structure = contours.structures[cut.structure];
        const std::string& slice = contours.slices[cut.slice].name;
        report.cuts.push_back({structure.name.empty() ? std::to_string(structure.number) : structure.name,
                               slice.empty() ? std::to_string(cut.slice) : slice, cut.drawn, cut.difference});
    }
    findings.vertex_of = std::move(fidelity.vertex_of);
    return findings;
}

// What clause 4 goes by.
struct ShapeFindings {
    std::uint64_t above = 0, forced = 0;  // cells above the bound; those of them that the contours force
    double mean_free = 0;                 // ratio of the cells that nothing is known to force
};

ShapeFindings list_cells(const CertificateInput& input, const CellShapes& shapes,
                         const ContourFindings& findings, int threads, ModelReport& report) {
    report.listed_cells.clear();
    report.listed_cells_total = shapes.over_bound.size();
    report.listed_cells_forced = 0;
    ShapeFindings found{shapes.over_bound.size(), 0, report.quality.radius_edge_mean};
    if (shapes.over_bound.empty()) return found;
    const ContourSet none;
    const ForcedCells forced(input.mesh, input.contours ? *input.contours : none, findings.vertex_of);
    for (const std::uint32_t c : shapes.over_bound) {
        ListedCell listed{c, shapes.radius_edge[c], {}, forced.reason(c)};
        found.forced += !listed.forced_by.empty();
        if (report.listed_cells.size() == max_listed_cells) continue;
        Vec3 sum;
        for (const std::uint32_t v : input.mesh.cells[c]) sum += input.mesh.points[v];
        listed.at = {sum.x / 4, sum.y / 4, sum.z / 4};
        report.listed_cells.push_back(std::move(listed));
    }
    report.listed_cells_forced = found.forced;
    if (input.contours) {
        // Pieces of a fixed size: the same mean at any number of threads.
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
        found.mean_free = count > 0 ? std::accumulate(sums.begin(), sums.end(), 0.0) / static_cast<double>(count) : 0;
    }
    return found;
}

// The whole number that a text begins with, 0 when it begins with none.
std::uint64_t leading_number(const std::string& text) {
    std::uint64_t number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
}

// What cleaning moved before the contours were kept: a vertex is exact with regard to those.
std::string moves_text(std::span<const Warning> warnings) {
    std::uint64_t onto_plane = 0, apart = 0, welded = 0;
    for (const Warning& warning : warnings) {
        onto_plane += warning.code == "W-CON-009";
        if (warning.code == "W-CON-020") apart += leading_number(warning.place.value);
        if (warning.code == "W-CON-021") welded += leading_number(warning.message);
    }
    std::string text;
    const auto add = [&](std::uint64_t count, const std::string& what) {
        if (count > 0) text += (text.empty() ? "" : ", ") + what;
    };
    add(apart, std::to_string(apart) + " moved apart where rings touch (W-CON-020)");
    add(welded, std::to_string(welded) + " moved onto one of another structure (W-CON-021)");
    add(onto_plane,
        "those of " + counted(onto_plane, "contour") + " off their plane moved onto it (W-CON-009)");
    return text.empty() ? "" : "; cleaning moved vertices before: " + text;
}

Clause clause_vertices(const CertificateInput& input, const StructureFidelity& all,
                       const RunContext& context) {
    Clause clause{
        1, ClauseState::not_promised_yet,
        "Every vertex of a kept contour is a vertex of its structure's surface, at its exact coordinates.",
        "not checked: no contours were given"};
    if (!input.contours) return clause;
    clause.state = all.vertices_on_surface == all.vertices ? ClauseState::kept : ClauseState::broken;
    clause.evidence = count_of(all.vertices_on_surface, all.vertices) +
                      " contour vertices are vertices of their structure's surface, bit for bit" +
                      moves_text(context.warnings);
    return clause;
}

// The cuts of the model beside the drawn regions: the sum, and the worst slice.
std::string cuts_text(const ModelReport& report, std::size_t& above) {
    double drawn = 0, difference = 0, worst = 0;
    std::string where;
    above = 0;
    for (const SliceCutReport& cut : report.cuts) {
        drawn += cut.drawn_mm2;
        difference += cut.difference_mm2;
        above += cut.difference_mm2 > certificate_cut_tolerance * cut.drawn_mm2;
        const double share = cut.drawn_mm2 > 0 ? cut.difference_mm2 / cut.drawn_mm2 : 0;
        if (share <= worst) continue;
        worst = share;
        where = " (" + cut.structure + ", slice " + cut.slice + ")";
    }
    return "on the slices where a structure is drawn: symmetric difference of the cuts by the slices' planes and the drawn regions " +
           percent_text(difference, drawn, 4) + " of the area in all, at most " + percent_text(worst, 1, 3) +
           where + ", above " + percent_text(certificate_cut_tolerance, 1, 1) + " in " +
           count_of(above, report.cuts.size()) + " cuts";
}

Clause clause_segments(const CertificateInput& input, const StructureFidelity& all,
                       const ModelReport& report) {
    Clause clause{
        2, ClauseState::not_promised_yet,
        "Every segment of a kept contour is a chain of surface edges; the cut of the model by the slice's "
        "plane is the drawn region.",
        "not checked: no contours were given"};
    if (!input.contours) return clause;
    clause.evidence =
        count_of(all.segments_on_surface, all.segments) + " contour segments (" +
        percent_text(static_cast<double>(all.segments_on_surface), static_cast<double>(all.segments), 2) +
        ") are chains of surface edges; ";
    std::size_t above = 0;
    clause.evidence += cuts_text(report, above);
    if (all.segments_on_surface == all.segments && above == 0) clause.state = ClauseState::kept;
    return clause;
}

Clause clause_validity(const MeshCheck& check, const ModelReport& report) {
    Clause clause{
        3, ClauseState::kept,
        "The surface of every structure is closed, oriented and 2-manifold at edges and vertices; regions "
        "share their interfaces facet for facet; all tetrahedra are positive, none twice; nothing overlaps.",
        ""};
    std::uint64_t open = 0, edges = 0, vertices = 0;
    for (const StructureReport& structure : report.structures) {
        open += structure.open_edges;
        edges += structure.nonmanifold_edges;
        vertices += structure.nonmanifold_vertices;
    }
    if (!check.valid() || open + edges + vertices > 0) clause.state = ClauseState::broken;
    clause.evidence =
        std::to_string(report.tetrahedra) + " tetrahedra, " + std::to_string(check.boundary_triangles) +
        " boundary facets, by exact arithmetic: " + to_line(check) +
        (check.boundary_checked ? "" : " (crossings of the boundary not checked)") + "; surfaces of " +
        counted(report.structures.size(), "structure") + ": " + std::to_string(open) + " open edges, " +
        std::to_string(edges) + " non-manifold edges, " + std::to_string(vertices) + " non-manifold vertices";
    return clause;
}

// A share of the total that rounds to nothing is still more than nothing.
std::string share_text(std::uint64_t part, std::uint64_t total) {
    if (part > 0 && 200'000 * part < total) return "below 0.001 %";
    return percent_text(static_cast<double>(part), static_cast<double>(total), 3);
}

Clause clause_shape(const CertificateInput& input, const ShapeFindings& found, const ModelReport& report) {
    const QualityReport& quality = report.quality;
    const std::uint64_t free = found.above - found.forced;
    Clause clause{4, ClauseState::kept,
                  "Radius-edge ratio at most 2 for every tetrahedron that the input does not force to be "
                  "worse, but for "
                  "0.5 % of them while the mean is at most 1.2; dihedral angles of at least 10 degrees are "
                  "not promised "
                  "yet.",
                  ""};
    // Negated, so that a mean that is no number breaks the clause.
    const bool tolerable =
        static_cast<double>(free) <= certificate_share_over_bound * static_cast<double>(report.tetrahedra) &&
        found.mean_free <= certificate_mean_radius_edge;
    if (free > 0 && !tolerable) clause.state = ClauseState::broken;
    clause.evidence = "radius-edge: " + count_of(found.above, report.tetrahedra) + " (" +
                      share_text(found.above, report.tetrahedra) + ") above 2, ";
    clause.evidence += input.contours ? std::to_string(found.forced) + " of them forced by contour points"
                                      : "what forces them is not known without contours";
    clause.evidence += ", mean " + fixed_text(quality.radius_edge_mean, 3);
    if (input.contours && found.above > 0)
        clause.evidence += " (" + fixed_text(found.mean_free, 3) + " where nothing forces)";
    clause.evidence += ", maximum " + fixed_text(quality.radius_edge_max, 2);
    if (found.above > 0) {
        clause.evidence += found.above <= max_listed_cells
                               ? ", all listed"
                               : ", the worst " + std::to_string(max_listed_cells) + " listed";
    }
    clause.evidence += "; smallest dihedral angle " + fixed_text(quality.dihedral_min_deg, 2) + " degrees, " +
                       std::to_string(quality.dihedral_below_10) + " tetrahedra below 10, " +
                       std::to_string(quality.dihedral_below_15) + " below 15";
    return clause;
}

Clause clause_determinism(const CertificateInput& input) {
    Clause clause{
        5, ClauseState::kept,
        "The same input gives the same bytes, for any number of threads and any order of slices and files "
        "(but for the report's object `timing`).",
        "by construction: no stage's result depends on the number of threads, on time or on addresses, and "
        "slices are put in a fixed order before the first stage"};
    if (!input.made_by_this_run) {
        clause.state = ClauseState::not_promised_yet;
        clause.evidence = "not checked: how this model was made is not known";
    }
    return clause;
}

Clause clause_volume(const CertificateInput& input, const ModelReport& report) {
    Clause clause{6, ClauseState::not_promised_yet,
                  "The volume by mesh equals the integral of the field's own cross-sections within 0.2 %.",
                  "not checked: the field was not at hand"};
    double total = 0, slices = 0, worst = 0;
    std::string worst_name;
    for (const StructureReport& structure : report.structures) {
        total += structure.volume_mesh_mm3;
        slices += structure.volume_slices_mm3;
        const double difference = std::abs(structure.volume_mesh_mm3 - structure.volume_field_mm3);
        if (difference == 0) continue;
        const double relative =
            structure.volume_field_mm3 > 0 ? difference / structure.volume_field_mm3 : HUGE_VAL;
        if (relative <= worst) continue;
        worst = relative;
        worst_name = structure.name.empty() ? std::to_string(structure.number) : structure.name;
    }
    const std::string beside =
        slices > 0 ? ", by plain slice integration " + fixed_text(slices / 1000, 3) : "";
    const std::string volume =
        "volume of all structures by mesh " + fixed_text(total / 1000, 3) + " ml" + beside;
    if (input.field_volumes_mm3.empty()) {
        clause.evidence += "; " + volume;
        return clause;
    }
    clause.state = worst <= certificate_volume_tolerance ? ClauseState::kept : ClauseState::broken;
    clause.evidence = "largest difference of a structure " + fixed_text(100 * worst, 3) + " %" +
                      (worst_name.empty() ? "" : " (" + worst_name + ")") + "; " + volume;
    return clause;
}

}  // namespace

void measure_model(const CertificateInput& input, const RunContext& context, ModelReport& report) {
    const TetMesh& mesh = input.mesh;
    assert(mesh.regions.size() == mesh.cells.size());
    assert(input.field_volumes_mm3.empty() || input.field_volumes_mm3.size() == input.structures.size());

    std::vector<std::uint32_t> neighbors;
    const MeshCheck check = check_mesh(mesh, context.threads, &neighbors);
    report.vertices = mesh.points.size();
    report.tetrahedra = mesh.cells.size();
    report.certificate.clear();
    if (check.count(MeshFault::index_out_of_range) > 0 || check.count(MeshFault::point_not_finite) > 0) {
        // Nothing can be measured on such a mesh.
        report.certificate.push_back(clause_validity(check, report));
        report.certificate.back().state = ClauseState::broken;
        return;
    }
    Surfaces surfaces;
    for (std::uint32_t s = 0; s < input.structures.size(); ++s) {
        surfaces.push_back(structure_surface(mesh, neighbors, input.regions, s));
    }
    report.surface_triangles = count_interface_facets(mesh, neighbors);
    measure_structures(input, surfaces, neighbors, report);
    ContourFindings findings;
    if (input.contours) findings = measure_contours(input, surfaces, report);
    const CellShapes shapes = measure_shapes(mesh, context);
    report.quality = shapes.report;
    const ShapeFindings shape = list_cells(input, shapes, findings, context.threads, report);

    report.certificate = {clause_vertices(input, findings.all, context),
                          clause_segments(input, findings.all, report),
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
