#include "summary.h"

#include <fmt/format.h>

#include "anatomesh/base/plural.h"
#include "session.h"

namespace anatomesh {

namespace {

// The summary has a line for so many structures; then their number is printed. [lines; >= 1; C]
constexpr std::size_t most_structures = 20;

const char* state_text(ClauseState state) {
    switch (state) {
        case ClauseState::kept:
            return "kept";
        case ClauseState::moved:
            return "moved";
        case ClauseState::not_promised_yet:
            return "not promised yet";
        case ClauseState::broken:
            return "BROKEN";
    }
    return "";
}

// "1 shell", "3 shells (1 void, smallest 0.25 mm3)".
std::string shells_text(const StructureReport& structure) {
    std::string text = counted(structure.surface.components, "shell");
    if (structure.surface.components < 2 && structure.shells.voids == 0) return text;
    return text + fmt::format(" ({}, smallest {:.3g} mm3)", counted(structure.shells.voids, "void"),
                              structure.shells.smallest_mm3);
}

std::string structure_line(const StructureReport& structure) {
    return fmt::format("  {:>6}  {:<28} {:>9} {}, {:.1f} mm3, {}, genus {}\n", structure.number,
                       on_one_line(structure.name), structure.tetrahedra,
                       structure.tetrahedra == 1 ? "tetrahedron" : "tetrahedra", structure.volume.mesh_mm3,
                       shells_text(structure), structure.surface.genus);
}

// How far and how many; nothing where contours were moved to edges of the surface alone.
std::string moved_text(const ContourMovementReport& movement) {
    if (movement.contours_moved == 0) return "";
    return fmt::format(" ({} of {} contours, by {:.3g} mm at most)", movement.contours_moved,
                       movement.contours, movement.farthest_mm);
}

}  // namespace

std::string report_summary(const ModelReport& report) {
    std::string text =
        fmt::format("  {}, {}, {}, {} {}\n", counted(report.counts.tetrahedra, "tetrahedron", "tetrahedra"),
                    counted(report.counts.vertices, "vertex", "vertices"),
                    counted(report.counts.surface_triangles, "triangle"), report.conventions.space,
                    report.conventions.unit);
    for (std::size_t i = 0; i < report.structures.size() && i < most_structures; ++i) {
        text += structure_line(report.structures[i]);
    }
    if (report.structures.size() > most_structures) {
        text +=
            fmt::format("  and {}\n", counted(report.structures.size() - most_structures, "more structure"));
    }
    const QualityReport& quality = report.quality;
    text += fmt::format(
        "  radius-edge mean {:.3f}, above 2: {:.3f} %; dihedral angles {:.2f} to {:.2f} degrees\n",
        quality.radius_edge.mean, 100 * quality.radius_edge.share_over_2, quality.dihedral_deg.min,
        quality.dihedral_deg.max);
    if (const FieldDistanceReport& distance = report.field.distance; distance.points > 0) {
        text += fmt::format("  farthest from the field: {}{:.3g} mm, at {:.1f} {:.1f} {:.1f}\n",
                            distance.at_least ? "at least " : "", distance.max_mm, distance.at[0],
                            distance.at[1], distance.at[2]);
    }
    return text;
}

std::string certificate_line(const ModelReport& report) {
    std::string text = "  certificate:";
    for (const ClauseState state :
         {ClauseState::kept, ClauseState::moved, ClauseState::not_promised_yet, ClauseState::broken}) {
        std::string numbers;
        for (const Clause& clause : report.certificate) {
            if (clause.state == state)
                numbers += fmt::format("{}{}", numbers.empty() ? "" : ", ", clause.number);
        }
        if (numbers.empty()) continue;
        const bool several = numbers.find(',') != std::string::npos;
        text += fmt::format(" {} {} {}{};", several ? "clauses" : "clause", numbers, state_text(state),
                            state == ClauseState::moved ? moved_text(report.crossing.movement) : "");
    }
    text.back() = '\n';
    return text;
}

std::string certificate_text(const ModelReport& report) {
    std::string text;
    for (const Clause& clause : report.certificate) {
        text += fmt::format("  clause {} {}: {}\n", clause.number, state_text(clause.state), clause.evidence);
    }
    return text;
}

}  // namespace anatomesh
