// Walls that structures share: what `model` does to drawn contours, and `check` after it.
#pragma once

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/close_gaps.h"
#include "anatomesh/contour/walls/share_lines.h"
#include "anatomesh/contour/walls/slivers.h"

namespace anatomesh {

// 0: as drawn.
struct WallOptions {
    double same_line_mm = ShareLinesOptions{}.width_mm;        // [0, 0.1]
    double close_slivers_mm = CloseSliversOptions{}.width_mm;  // [0, 10]
    double close_gaps_mm = CloseGapsOptions{}.width_mm;        // [0, 10]
};

// share_lines(), then close_slivers(), then close_gaps(). Warnings: W-CON-027, -028, -025, how much was
// changed. Requires: a kept set.
void share_walls(ContourSet& kept, const WallOptions& options, RunContext& context);

}  // namespace anatomesh
