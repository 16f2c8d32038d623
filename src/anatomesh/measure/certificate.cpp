#include "anatomesh/measure/certificate.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/number_text.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/measure/contour_fidelity.h"
#include "anatomesh/measure/field_difference.h"
#include "anatomesh/measure/field_distance.h"
#include "anatomesh/measure/quality_report.h"
#include "anatomesh/measure/shells.h"
#include "anatomesh/measure/slice_sections.h"
#include "anatomesh/measure/volume.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/check/validity.h"

namespace anatomesh {

namespace {

using Surfaces = std::vector<std::vector<Triangle>>;           // by structure
using ShellNumbers = std::vector<std::vector<std::uint32_t>>;  // of their triangles

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

ShellNumbers measure_structures(const CertificateInput& input, const Surfaces& surfaces,
                                std::span<const std::uint32_t> neighbors, int threads, ModelReport& report) {
    const TetMesh& mesh = input.mesh;
    std::vector<double> volumes;
    std::vector<SurfaceTopology> topologies(surfaces.size());
    ShellNumbers shells(surfaces.size());
    std::vector<std::uint64_t> pieces(surfaces.size());
    parallel_tasks(threads, {[&] { volumes = mesh_volumes(mesh, input.regions, input.structures.size()); },
                             [&] {
                                 parallel_for(
                                     surfaces.size(), 1, threads, [&](std::size_t first, std::size_t last) {
                                         for (std::size_t s = first; s < last; ++s)
                                             topologies[s] = surface_topology(surfaces[s], &shells[s]);
                                     });
                             },
                             [&] {
                                 for (std::uint32_t s = 0; s < surfaces.size(); ++s)
                                     pieces[s] = structure_pieces(mesh, neighbors, input.regions, s);
                             }});
    std::vector<std::uint64_t> cells_of_region(input.regions.members.size(), 0);
    for (const Region region : mesh.regions) ++cells_of_region[region];
    report.structures.clear();
    for (std::uint32_t s = 0; s < input.structures.size(); ++s) {
        const SurfaceTopology& topology = topologies[s];
        StructureReport structure;
        structure.number = input.structures[s].number;
        structure.name = input.structures[s].name;
        structure.color = input.structures[s].color;
        for (std::size_t r = 0; r < cells_of_region.size(); ++r) {
            if (input.regions.contains(static_cast<Region>(r), s)) structure.tetrahedra += cells_of_region[r];
        }
        structure.surface.triangles = topology.triangles;
        structure.surface.vertices = topology.vertices;
        structure.volume.mesh_mm3 = volumes[s];
        if (!input.field_volumes_mm3.empty()) structure.volume.field_mm3 = input.field_volumes_mm3[s];
        structure.surface.area_mm2 = surface_area(mesh.points, surfaces[s]);
        structure.surface.components = topology.components;
        structure.pieces = pieces[s];
        structure.shells = count_shells(mesh.points, surfaces[s], shells[s]);
        structure.surface.genus = topology.genus;
        structure.surface.open_edges = topology.open_edges;
        structure.surface.nonmanifold_edges = topology.nonmanifold_edges + topology.misoriented_edges;
        structure.surface.nonmanifold_vertices = topology.nonmanifold_vertices;
        report.structures.push_back(std::move(structure));
    }
    report.regions = input.regions.members;
    return shells;
}

std::uint64_t count_interface_facets(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                     int threads) {
    std::atomic<std::uint64_t> all = 0;
    parallel_for(neighbors.size(), 65536, threads, [&](std::size_t first, std::size_t last) {
        std::uint64_t count = 0;
        for (std::size_t facet = first; facet < last; ++facet) {
            const std::uint32_t other = neighbors[facet];
            count += mesh.regions[facet / 4] > (other == no_cell ? Region{0} : mesh.regions[other]);
        }
        all.fetch_add(count, std::memory_order_relaxed);
    });
    return all;
}

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

// Where a structure is not drawn, cross-sections are listed that are more than the tolerance of what it has on a slice.
// `segments_missed`: by contour of `kept`.
void list_sections(const ContourSet& contours, const std::vector<SliceSection>& sections,
                   const ContourSet& kept, const std::vector<std::uint32_t>& segments_missed,
                   ModelReport& report) {
    std::vector<double> drawn(contours.structures.size(), 0), slices(drawn);
    for (const SliceSection& section : sections) {
        drawn[section.structure] += section.drawn;
        slices[section.structure] += section.drawn > 0;
    }
    report.contours.sections.clear();
    report.contours.sections_not_drawn = 0;
    for (const SliceSection& section : sections) {
        const bool is_drawn = section.drawn > 0;
        report.contours.sections_not_drawn += !is_drawn;
        const double mean =
            slices[section.structure] > 0 ? drawn[section.structure] / slices[section.structure] : 0;
        if (!is_drawn && section.difference <= contract::section_tolerance * mean) continue;
        const Structure& structure = contours.structures[section.structure];
        const Slice& slice = contours.slices[section.slice];
        SliceSectionReport entry{structure.name.empty() ? std::to_string(structure.number) : structure.name,
                                 slice.name.empty() ? std::to_string(section.slice) : slice.name,
                                 section.drawn, section.difference, 0};
        for (std::uint32_t c = slice.first_contour; c < slice.first_contour + slice.contour_count; ++c) {
            if (kept.contours[c].structure == section.structure) entry.segments_missed += segments_missed[c];
        }
        report.contours.sections.push_back(std::move(entry));
    }
}

// Counts of contour vertices and segments on the surfaces; the vertex of every contour point.
struct ContourFindings {
    StructureFidelity all;
    std::uint64_t contradicted = 0;  // of the segments missed
    std::vector<std::uint32_t> vertex_of;
};

ContourFindings measure_contours(const CertificateInput& input, const Surfaces& surfaces,
                                 const ShellNumbers& shells, ModelReport& report) {
    const ContourSet &contours = *input.contours, &kept = input.on_surface ? *input.on_surface : contours;
    report.counts.slices = contours.slices.size();
    report.counts.contours = contours.contours.size();
    report.counts.contour_vertices = kept.points.size();
    if (all_parallel(contours, parallel_tolerance_mm))
        report.lengths.slice_spacing_mm = median_spacing(contours);
    Surfaces of_contours(contours.structures.size());
    std::vector<std::size_t> match(contours.structures.size());
    for (std::uint32_t s = 0; s < match.size(); ++s) {
        match[s] = matching_structure(contours.structures, s, input.structures);
        if (match[s] < surfaces.size()) of_contours[s] = surfaces[match[s]];
    }
    ContourFidelity fidelity = contour_fidelity(input.mesh.points, of_contours, kept);
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
        structure.fidelity.vertices += part.vertices;
        structure.fidelity.vertices_on_surface += part.vertices_on_surface;
        structure.fidelity.segments += part.segments;
        structure.fidelity.segments_on_surface += part.segments_on_surface;
        if (!volumes.empty()) structure.volume.slices_mm3 += volumes[s];
    }
    for (const SegmentOfContour& segment : contradicted_segments(kept, fidelity.missed)) {
        const std::size_t s = match[kept.contours[segment.contour].structure];
        ++findings.contradicted;
        if (s < report.structures.size()) ++report.structures[s].fidelity.segments_contradicted;
    }
    for (std::uint32_t s = 0; s < surfaces.size(); ++s) {
        look_for_contours(input.mesh.points, surfaces[s], shells[s], kept, match, s, fidelity.vertex_of,
                          report.structures[s].shells);
    }
    findings.vertex_of = input.on_surface
                             ? contour_fidelity(input.mesh.points, of_contours, contours).vertex_of
                             : std::move(fidelity.vertex_of);
    list_sections(contours, slice_sections(input.mesh.points, of_contours, contours, findings.vertex_of),
                  kept, fidelity.segments_missed, report);
    return findings;
}

// What clause 4 goes by.
struct ShapeFindings {
    std::uint64_t above = 0, forced = 0;  // cells above the bound; those of them that the contours force
    double mean_free = 0;                 // ratio of the cells that nothing is known to force
    std::uint64_t bad = 0, gross = 0;     // that nothing is known to force and that are beyond these bounds
    std::uint64_t forced_gross = 0;       // that the contours force, and beyond the latter
    std::vector<ListedCell> worst;        // some of all these
};

constexpr std::size_t named_places = 3;  // A clause names no more. [places; >= 1; C]

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

// The whole number that a text begins with, 0 when it begins with none.
std::uint64_t leading_number(const std::string& text) {
    std::uint64_t number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
}

// What cleaning moved before the contours were kept: a vertex is exact with regard to those.
std::string moves_text(std::span<const Warning> warnings) {
    std::uint64_t onto_plane = 0, apart = 0, welded = 0, copied = 0;
    for (const Warning& warning : warnings) {
        onto_plane += warning.code == "W-CON-009";
        if (warning.code == "W-CON-020") apart += leading_number(warning.place.value);
        if (warning.code == "W-CON-021") welded += leading_number(warning.message);
        if (warning.code == "W-CON-027") copied += leading_number(warning.message);
    }
    std::string text;
    const auto add = [&](std::uint64_t count, const std::string& what) {
        if (count > 0) text += (text.empty() ? "" : ", ") + what;
    };
    add(apart, std::to_string(apart) + " moved apart where contours touch (W-CON-020)");
    add(welded, std::to_string(welded) + " moved onto one of another structure (W-CON-021)");
    add(copied, std::to_string(copied) + " moved onto a close one of another structure (W-CON-027)");
    add(onto_plane, "those of " + counted(onto_plane, "contour") + " projected onto their plane (W-CON-009)");
    return text.empty() ? "" : "; vertices that cleaning moved before: " + text;
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

std::string place_text(const SliceSectionReport& section) {
    return section.structure + ", slice " + section.slice;
}

// The first few of the cross-sections that `wanted` picks, those with the largest `value` first.
template <class Wanted, class Value, class Text>
std::string worst_places(const ModelReport& report, const Wanted& wanted, const Value& value,
                         const Text& text) {
    std::vector<const SliceSectionReport*> worst;
    for (const SliceSectionReport& section : report.contours.sections) {
        if (wanted(section)) worst.push_back(&section);
    }
    std::stable_sort(worst.begin(), worst.end(),
                     [&](const auto* a, const auto* b) { return value(*a) > value(*b); });
    std::string places;
    for (std::size_t n = 0; n < std::min(worst.size(), named_places); ++n)
        places += (n > 0 ? "; " : "") + place_text(*worst[n]) + ": " + text(*worst[n]);
    return places;
}

// The cross-sections of the model beside the drawn regions: the sum, the worst slices, and how many are not as drawn.
std::string cuts_text(const ModelReport& report, std::size_t& above) {
    const auto is_drawn = [](const SliceSectionReport& section) { return section.drawn_mm2 > 0; };
    const auto share = [](const SliceSectionReport& section) {
        return section.difference_mm2 / section.drawn_mm2;
    };
    const auto too_far = [&](const SliceSectionReport& section) {
        return is_drawn(section) && section.difference_mm2 > contract::section_tolerance * section.drawn_mm2;
    };
    double drawn = 0, difference = 0, worst = 0;
    std::size_t total = 0, far = 0, strange = 0;
    for (const SliceSectionReport& section : report.contours.sections) {
        far += too_far(section);
        if (!is_drawn(section)) {
            ++strange;
            continue;
        }
        ++total;
        drawn += section.drawn_mm2;
        difference += section.difference_mm2;
        worst = std::max(worst, share(section));
    }
    above = far + strange;
    std::string text =
        "on the slices where a structure is drawn: difference between the model's cross-sections and the "
        "drawn "
        "regions " +
        percent_text(difference, drawn, 4) + " of the area in all, at most " + percent_text(worst, 1, 3) +
        ", above " + percent_text(contract::section_tolerance, 1, 1) + " in " + count_of(far, total) +
        " cross-sections";
    if (far > 0) {
        text += " (" +
                worst_places(report, too_far, share,
                             [&](const SliceSectionReport& section) {
                                 return percent_text(share(section), 1, 3) + ", " +
                                        fixed_text(section.difference_mm2, 2) + " mm2";
                             }) +
                ")";
    }
    text += "; where it is not drawn: cross-sections in " +
            count_of(strange, report.contours.sections_not_drawn) + " slices";
    if (strange > 0) {
        text += " (" +
                worst_places(
                    report, [&](const SliceSectionReport& section) { return !is_drawn(section); },
                    [](const SliceSectionReport& section) { return section.difference_mm2; },
                    [](const SliceSectionReport& section) {
                        return fixed_text(section.difference_mm2, 2) + " mm2";
                    }) +
                ")";
    }
    return text;
}

std::string routed_text(const ModelReport& report) {
    if (report.contours.routed.empty()) return {};
    std::uint64_t segments = 0;
    double farthest_mm = 0;
    for (const RoutedContourReport& contour : report.contours.routed) {
        segments += contour.segments;
        farthest_mm = std::max(farthest_mm, contour.farthest_mm);
    }
    return ", " + std::to_string(report.contours.routed.size()) +
           " of the contours after they were moved to edges of the surface at " + std::to_string(segments) +
           " drawn segments, by at most " + fixed_text(farthest_mm, 3) + " mm";
}

std::string segments_text(const ContourFindings& findings, const ModelReport& report) {
    const StructureFidelity& all = findings.all;
    std::string text =
        count_of(all.segments_on_surface, all.segments) + " contour segments (" +
        percent_text(static_cast<double>(all.segments_on_surface), static_cast<double>(all.segments), 2) +
        ") are chains of surface edges" + routed_text(report);
    if (all.segments_on_surface == all.segments) return text;
    const auto missed = [](const SliceSectionReport& section) { return section.segments_missed; };
    text += " (missed most in " +
            worst_places(report, missed, missed,
                         [&](const SliceSectionReport& section) { return std::to_string(missed(section)); }) +
            ")";
    if (findings.contradicted > 0)
        text += ", " + std::to_string(findings.contradicted) +
                " of the others cross another slice where that slice contradicts them";
    return text;
}

// The structure whose cross-sections by all slices together are farthest from what is drawn, where that is gross.
std::string gross_cuts_text(const ModelReport& report) {
    std::map<std::string, std::array<double, 2>> areas;  // of a structure: drawn, amiss
    for (const SliceSectionReport& section : report.contours.sections) {
        areas[section.structure][0] += section.drawn_mm2;
        areas[section.structure][1] += section.difference_mm2;
    }
    std::string text;
    double worst = contract::gross_section_share;
    for (const auto& [name, area] : areas) {
        if (area[1] <= worst * area[0]) continue;
        if (area[0] > 0) worst = area[1] / area[0];
        const auto of_it = [&, n = &name](const SliceSectionReport& section) {
            return section.structure == *n;
        };
        text = "of all slices together " + percent_text(area[1], area[0], 1) + " of the drawn area of " +
               name + " are wrong, more than " + percent_text(contract::gross_section_share, 1, 0) +
               " (most on " +
               worst_places(
                   report, of_it, [](const SliceSectionReport& section) { return section.difference_mm2; },
                   [](const SliceSectionReport& section) {
                       return fixed_text(section.difference_mm2, 2) + " of " +
                              fixed_text(section.drawn_mm2, 2) + " mm2";
                   }) +
               "); ";
    }
    return text;
}

Clause clause_segments(const CertificateInput& input, const ContourFindings& findings,
                       const ModelReport& report) {
    Clause clause{
        2, ClauseState::not_promised_yet,
        "Every segment of a kept contour is a chain of surface edges; the cross-section of the model in the "
        "slice's plane is the drawn region, and empty where a structure is not drawn.",
        "not checked: no contours were given"};
    if (!input.contours) return clause;
    std::size_t above = 0;
    clause.evidence = segments_text(findings, report) + "; " + cuts_text(report, above);
    if (findings.all.segments_on_surface == findings.all.segments && above == 0) {
        clause.state = ClauseState::kept;
        return clause;
    }
    const std::string gross = gross_cuts_text(report);
    if (!gross.empty()) clause.state = ClauseState::broken;
    clause.evidence = "measured, not met: " + gross + clause.evidence;
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
        open += structure.surface.open_edges;
        edges += structure.surface.nonmanifold_edges;
        vertices += structure.surface.nonmanifold_vertices;
    }
    if (!check.valid() || open + edges + vertices > 0) clause.state = ClauseState::broken;
    clause.evidence = std::to_string(report.counts.tetrahedra) + " tetrahedra, " +
                      std::to_string(check.boundary_triangles) +
                      " boundary facets, by exact arithmetic: " + to_line(check) +
                      (check.boundary_checked ? "" : " (crossings of the boundary not checked)") +
                      "; surfaces of " + counted(report.structures.size(), "structure") + ": " +
                      std::to_string(open) + " open edges, " + std::to_string(edges) +
                      " non-manifold edges, " + std::to_string(vertices) + " non-manifold vertices";
    return clause;
}

// A share of the total that rounds to nothing is still more than nothing.
std::string share_text(std::uint64_t part, std::uint64_t total) {
    if (part > 0 && 200'000 * part < total) return "below 0.001 %";
    return percent_text(static_cast<double>(part), static_cast<double>(total), 3);
}

std::string bad_cells_text(const ShapeFindings& found) {
    std::string text =
        std::to_string(found.bad) +
        " of the tetrahedra without a known reason in the contours are beyond ratio 4 or angle 10 degrees, " +
        std::to_string(found.gross) + " beyond 100 or 0.05, and " + std::to_string(found.forced_gross) +
        " of those that contours force (";
    for (std::size_t n = 0; n < found.worst.size(); ++n) {
        const ListedCell& cell = found.worst[n];
        text += (n > 0 ? "; " : "") + std::string("at ") + fixed_text(cell.at[0], 1) + " " +
                fixed_text(cell.at[1], 1) + " " + fixed_text(cell.at[2], 1) + ": ratio " +
                fixed_text(cell.value, 2) + ", angle " + fixed_text(cell.min_dihedral_deg, 2) +
                (cell.forced_by.empty() ? "" : ", forced");
    }
    return text + ")";
}

Clause clause_shape(const CertificateInput& input, const ShapeFindings& found, const ModelReport& report) {
    const QualityReport& quality = report.quality;
    const std::uint64_t free = found.above - found.forced;
    Clause clause{
        4, ClauseState::kept,
        "Radius-edge ratio at most 2 for every tetrahedron that the input does not force to be "
        "worse, except 0.5 % of them while the mean is at most 1.2; at most 4 for each, with "
        "dihedral angles of at least 10 degrees; for none above 100 or with an angle below 0.05 degrees.",
        ""};
    // Negated, so that a mean that is no number breaks the clause.
    const bool tolerable = static_cast<double>(free) <=
                               contract::share_over_bound * static_cast<double>(report.counts.tetrahedra) &&
                           found.mean_free <= contract::mean_radius_edge;
    if (found.bad + found.forced_gross > 0) clause.state = ClauseState::not_promised_yet;
    if ((free > 0 && !tolerable) || found.gross > 0) clause.state = ClauseState::broken;
    clause.evidence = "radius-edge: " + count_of(found.above, report.counts.tetrahedra) + " (" +
                      share_text(found.above, report.counts.tetrahedra) + ") above 2, ";
    clause.evidence += input.contours ? std::to_string(found.forced) + " of them forced by contour points"
                                      : "the reason is not known without contours";
    clause.evidence += ", mean " + fixed_text(quality.radius_edge.mean, 3);
    if (input.contours && found.above > 0)
        clause.evidence += " (" + fixed_text(found.mean_free, 3) + " for those not forced)";
    clause.evidence += ", maximum " + fixed_text(quality.radius_edge.max, 2);
    if (found.above > 0) {
        clause.evidence += report.listed_cells.total <= max_listed_cells
                               ? ", all listed"
                               : ", the worst " + std::to_string(max_listed_cells) + " listed";
    }
    clause.evidence += "; smallest dihedral angle " + fixed_text(quality.dihedral_deg.min, 2) + " degrees, " +
                       std::to_string(quality.dihedral_deg.below_10) + " tetrahedra below 10, " +
                       std::to_string(quality.dihedral_deg.below_15) + " below 15";
    if (found.bad + found.forced_gross > 0)
        clause.evidence = "measured, not met: " + bad_cells_text(found) + "; " + clause.evidence;
    return clause;
}

Clause clause_determinism(const CertificateInput& input) {
    Clause clause{
        5, ClauseState::kept,
        "The same input gives the same bytes, for any number of threads and any order of slices and files "
        "(except the report's object `timing`).",
        "by construction: no stage's result depends on the number of threads, on time or on addresses, and "
        "slices are put in a fixed order before the first stage"};
    if (!input.made_by_this_run) {
        clause.state = ClauseState::not_promised_yet;
        clause.evidence = "not checked: this run did not make the model";
    }
    return clause;
}

Clause clause_volume(const CertificateInput& input, const ModelReport& report) {
    Clause clause{6, ClauseState::not_promised_yet,
                  "The volume by mesh equals the integral of the field's own cross-sections within 0.2 %.",
                  "not checked: the field of the contours was not available"};
    double total = 0, slices = 0, worst = 0;
    std::string worst_name;
    for (const StructureReport& structure : report.structures) {
        total += structure.volume.mesh_mm3;
        slices += structure.volume.slices_mm3;
        const double difference = std::abs(structure.volume.mesh_mm3 - structure.volume.field_mm3);
        if (difference == 0) continue;
        const double relative =
            structure.volume.field_mm3 > 0 ? difference / structure.volume.field_mm3 : HUGE_VAL;
        if (relative <= worst) continue;
        worst = relative;
        worst_name = structure.name.empty() ? std::to_string(structure.number) : structure.name;
    }
    const std::string beside =
        slices > 0 ? ", by plain slice integration " + fixed_text(slices / 1000, 3) : "";
    const std::string volume =
        "volume of all structures by mesh " + fixed_text(total / 1000, 3) + " ml" + beside;
    const std::string note = input.field_note.empty() ? "" : ", " + std::string(input.field_note);
    if (input.field_volumes_mm3.empty()) {
        if (!note.empty()) clause.evidence = "not checked" + note;
        clause.evidence += "; " + volume;
        return clause;
    }
    clause.state = worst <= contract::volume_tolerance ? ClauseState::kept : ClauseState::broken;
    clause.evidence = "largest difference of a structure " + fixed_text(100 * worst, 3) + " %" +
                      (worst_name.empty() ? "" : " (" + worst_name + ")") + note + "; " + volume;
    return clause;
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
