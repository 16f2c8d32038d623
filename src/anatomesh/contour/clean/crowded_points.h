// leave_out_crowded: contours without points that lie very near to the next one. Cells as fine as their spacing
// would be finer than anything that is drawn.
#pragma once

#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct CrowdedOptions {
    double nearer_mm = 0.01;  // a point nearer than this to the next one is crowded. 0: none is. [0, 1]
    double within_mm = 1e-3;  // points farther from the line that is kept than this stay. (0, nearer_mm]
};

struct CrowdedPoints {
    ContourSet kept;
    std::vector<Vec3> left_out;  // in lexicographic order
    double distance_mm = 0;      // of one from the line that is kept, at most
};

// Whether any point lies nearer than this to the next one of its contour. O(n).
bool has_crowded(const ContourSet& set, double nearer_mm);

// Requires: a kept contour set. Guarantees: those of simplify_contours(). Points that are not crowded stay at their
// exact coordinates, so a set without crowded ones is returned as it was. At most 128 points in a row go, so a
// share of any number of crowded points stays. Complexity: O(n) without crowded points, else that of
// simplify_contours(). Errors: none of its own.
Result<CrowdedPoints> leave_out_crowded(ContourSet set, const CrowdedOptions& options, RunContext& context);

}  // namespace anatomesh
