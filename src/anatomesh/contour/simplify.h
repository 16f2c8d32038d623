// simplify_contours: fewer vertices, within a stated distance, with the same topology.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/contour_set.h"

namespace anatomesh {

struct SimplifyOptions {
    double epsilon_mm = 0;          // every input vertex stays within this of the kept polygon. 0: keep all. [0, 10]
    double min_vertex_spacing_mm = 0;  // aimed at between kept vertices where epsilon allows; 0: none
};

struct SimplifyStats {
    std::uint64_t points_in = 0, points_kept = 0;
    double max_distance_mm = 0;     // measured, of an input vertex from the kept polygon
};

struct SimplifyResult {
    ContourSet kept;
    SimplifyStats stats;
};

// Guarantees: kept vertices are input vertices at their exact coordinates; no contour crosses itself or another
// contour of its slice that it did not cross before; nesting is unchanged; a chain that two structures share
// stays shared, vertex for vertex; no contour falls below three vertices. Where a simplification would break one
// of these, the chain keeps more vertices there.
// Complexity: O(n log n) expected.
// Follows: Douglas and Peucker, Cartographica 10, 1973; safety check after Saalfeld, Cartography and GIS 26, 1999.
Result<SimplifyResult> simplify_contours(const ContourSet& set, const SimplifyOptions& options, RunContext& context);

}  // namespace anatomesh
