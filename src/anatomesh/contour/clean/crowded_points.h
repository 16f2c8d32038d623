// leave_out_crowded: contours without points that lie so near to the next that cells of their own spacing
// would be finer than anything that is drawn.
#pragma once

#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct CrowdedOptions {
    double nearer_mm = 0.01;  // than this to the next one along the contour: crowded. 0: none is. [0, 1]
    double within_mm = 1e-3;  // of the line through those kept: only such are left out. (0, nearer_mm]
};

struct CrowdedPoints {
    ContourSet kept;
    std::vector<Vec3> left_out;  // in lexicographic order
    double distance_mm = 0;      // of one from the line that is kept, at most
};

// Whether any point lies nearer than this to the next one of its contour. O(n).
bool has_crowded(const ContourSet& set, double nearer_mm);

// Requires: a kept contour set. Guarantees: those of simplify_contours(); points that are not crowded stay
// at their exact coordinates, so that a set without crowded ones is returned as it was. Of any number of
// points closer than that a share stays (128 at most in a row go): none is much nearer to the next than the
// points of a dense drawing. Complexity: O(n) without crowded points, else that of simplify_contours().
// Errors: none of its own.
Result<CrowdedPoints> leave_out_crowded(ContourSet set, const CrowdedOptions& options, RunContext& context);

}  // namespace anatomesh
