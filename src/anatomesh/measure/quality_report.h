// The shape of all cells of a mesh in figures.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct CellShapes {
    QualityReport report;
    std::vector<std::uint32_t> over_bound;  // cells with radius-edge above 2, worst first; then those with an
                                            // angle below 10 degrees, worst first
    std::vector<double> radius_edge, min_dihedral_deg;  // per cell
};

// Percentiles are the smallest value that at least the named share of the cells does not exceed; the mean of
// the edges counts every edge of every cell. All 0 without cells. Complexity: O(cells). Same for any number
// of threads.
CellShapes measure_shapes(const TetMesh& mesh, const RunContext& context);

}  // namespace anatomesh
