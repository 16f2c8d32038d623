#include "anatomesh/measure/certificate/clauses.h"

#include <charconv>
#include <cmath>
#include <string>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/number_text.h"
#include "anatomesh/base/plural.h"
#include "anatomesh/measure/certificate/count_text.h"

namespace anatomesh {

namespace {

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

}  // namespace

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

Clause clause_shape(const CertificateInput& input, const ShapeFindings& found, const ModelReport& report) {
    const QualityReport& quality = report.quality;
    const std::uint64_t free = found.above - found.forced;
    Clause clause{
        4, ClauseState::kept,
        "Radius-edge ratio at most 2 for every tetrahedron that the input does not force to be "
        "worse, except 0.5 % of them while the mean is at most 1.2; at most 4 for each, with "
        "dihedral angles of at least 10 degrees; for none above 100 or with an angle below 0.05 degrees.",
        ""};
    // A mean that is no number is not tolerable.
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

}  // namespace anatomesh
