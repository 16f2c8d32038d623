// share_walls: walls that neighbouring structures share, in drawn contours.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/close_gaps.h"
#include "anatomesh/contour/walls/merge_coincident.h"
#include "anatomesh/contour/walls/slivers.h"

namespace anatomesh {

// Widths in mm of the steps of these names; at 0 a step leaves contours as drawn.
struct WallOptions {
    double same_line_mm = MergeCoincidentOptions{}.width_mm;   // [0, 0.1]
    double close_slivers_mm = CloseSliversOptions{}.width_mm;  // [0, 10]
    double close_gaps_mm = CloseGapsOptions{}.width_mm;        // [0, 10]

    bool operator==(const WallOptions&) const = default;
};

// Runs merge_coincident(), then close_slivers(), then close_gaps(). Warnings: W-CON-027, -028 and -025 say how much each
// of them changed. Requires: a kept contour set. Guarantees and complexity: those of the three.
void share_walls(ContourSet& kept, const WallOptions& options, RunContext& context);

}  // namespace anatomesh
