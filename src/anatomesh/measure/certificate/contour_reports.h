// measure_contours: how far a model has the contours that it was made of.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/measure/certificate/structure_reports.h"
#include "anatomesh/measure/contour_fidelity.h"

namespace anatomesh {

// Counts of contour vertices and segments on the surfaces; the vertex of every contour point.
struct ContourFindings {
    StructureFidelity all;
    std::uint64_t contradicted = 0;  // of the segments missed
    std::vector<std::uint32_t> vertex_of;
    std::vector<std::uint32_t> structure_of;  // of each of report.contours.sections, in the contours
};

// Fills report.counts of contours, contours.sections, contours.sections_not_drawn, of parallel slices
// lengths.slice_spacing_mm, and of each structure fidelity, volume.slices_mm3 and what shells tell of contours.
// `surfaces`, `shells`: of input.structures. Requires: input.contours; measure_structures() before. The
// certificate takes nothing from earlier stages: what slices say of structures is found anew.
ContourFindings measure_contours(const CertificateInput& input, const Surfaces& surfaces,
                                 const ShellNumbers& shells, ModelReport& report);

}  // namespace anatomesh
