#include "anatomesh/measure/certificate/contour_reports.h"

#include "anatomesh/base/contract.h"
#include "anatomesh/measure/contradicted_segments.h"
#include "anatomesh/measure/shells.h"
#include "anatomesh/measure/slice_sections.h"
#include "anatomesh/measure/volume.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

namespace {

// Where a structure is not drawn, cross-sections are listed that are more than the tolerance of what it has on a slice.
// `segments_missed`: by contour of `kept`. Returns the structure of each that is listed, which names may not tell.
std::vector<std::uint32_t> list_sections(const ContourSet& contours,
                                         const std::vector<SliceSection>& sections, const ContourSet& kept,
                                         const std::vector<std::uint32_t>& segments_missed,
                                         ModelReport& report) {
    std::vector<std::uint32_t> structure_of;
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
        structure_of.push_back(section.structure);
    }
    return structure_of;
}

SliceCoverage coverage_of_slices(const ContourSet& contours) {
    if (contours.slices.empty()) return SliceCoverage(contours);
    RunContext context;
    return coverage_of(contours, arrangement_of(contours), context);
}

}  // namespace

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
    const SliceCoverage coverage = coverage_of_slices(contours);
    const std::vector<double> volumes = slice_volumes(contours, coverage);
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
    findings.structure_of = list_sections(
        contours, slice_sections(input.mesh.points, of_contours, contours, coverage, findings.vertex_of),
        kept, fidelity.segments_missed, report);
    return findings;
}

}  // namespace anatomesh
