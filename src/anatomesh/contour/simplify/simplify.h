// simplify_contours: fewer vertices, within a stated distance, with the same topology.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct SimplifyOptions {
    double epsilon_mm = 0;  // every input vertex stays within this of the kept polygon. 0: keep all. [0, 10]
    double min_vertex_spacing_mm = 0;  // aimed at between kept vertices where epsilon allows; 0: none
    double crowded_mm = 0;  // only vertices nearer than this to the next one may go; 0: any may. >= 0
};

struct SimplifyStats {
    std::uint64_t points_in = 0, points_kept = 0;
    double max_distance_mm = 0;  // measured, of an input vertex from the kept segment that spans it
};

struct SimplifyResult {
    ContourSet kept;
    SimplifyStats stats;
};

// Requires: a kept contour set.
// Guarantees: a kept contour set. Kept vertices are input vertices at their exact coordinates, and no contour falls
// below three of them. No contour crosses or touches itself or another contour of its slice that it did not cross or
// touch before. Nesting is unchanged. A chain that two contours share stays shared, vertex for vertex. Where a
// simplification would break one of these, the chain keeps more vertices. The output is the same for any order of the
// contours and any number of threads. Complexity: O(n log n) expected; parallel over slices. Errors: none of its own.
// Warnings: W-CON-024 where the area of a structure changes by more than 5 %. Source: that of thin_chains()
// (contour/simplify/chains.h).
Result<SimplifyResult> simplify_contours(const ContourSet& set, const SimplifyOptions& options,
                                         RunContext& context);

}  // namespace anatomesh
