// find_isolated_slices: slices that share nothing with any slice whose drawn region they cross.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

struct IsolatedSlice {
    std::uint32_t slice = 0;
    std::uint32_t nearest = 0;  // of the slices that draw one of its structures elsewhere on the common line
    std::uint32_t others = 0;   // how many of them there are
    double gap_mm = 0;          // along the line, to what the nearest draws
};

// A slice is isolated if on the common line with each slice that draws the same structure the two have
// nothing of it in common. Such slices do not contradict each other, because beyond its own contours
// neither says anything. They may be two parts of a structure, or one of them is out of place. A slice
// that is isolated by a single other one, which is isolated by several, is left out. In order of slices.
// `comparisons`: of the set (compare_planes). Complexity: O(slices^2) with a small factor, and that of
// compare_planes for pairs whose patches each pass through the other plane.
std::vector<IsolatedSlice> find_isolated_slices(const ContourSet& set, const std::vector<PlanePatch>& patches,
                                                std::span<const LineComparison> comparisons,
                                                RunContext& context);

}  // namespace anatomesh
