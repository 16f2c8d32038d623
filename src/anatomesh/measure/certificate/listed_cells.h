// list_cells: the cells beyond the bounds of clause 4, and which of them the contours force.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/measure/certificate/contour_reports.h"
#include "anatomesh/measure/quality_report.h"

namespace anatomesh {

// What clause 4 goes by.
struct ShapeFindings {
    std::uint64_t above = 0, forced = 0;  // cells above the bound; those of them that the contours force
    double mean_free = 0;                 // ratio of the cells that nothing is known to force
    std::uint64_t bad = 0, gross = 0;     // that nothing is known to force and that are beyond these bounds
    std::uint64_t forced_gross = 0;       // that the contours force, and beyond the latter
    std::vector<ListedCell> worst;        // some of all these, as many as a clause names
};

inline constexpr std::size_t named_places = 3;  // A clause names no more. [places; >= 1; C]

// Fills report.listed_cells. `shapes`: of the mesh; `findings`: by measure_contours(), empty without contours.
// Requires: report.quality. Guarantees: the same at any number of threads.
ShapeFindings list_cells(const CertificateInput& input, const CellShapes& shapes,
                         const ContourFindings& findings, int threads, ModelReport& report);

}  // namespace anatomesh
