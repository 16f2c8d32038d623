// judged_stacks: the stacks of a contour set, in which slices are compared with those beside them.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

struct JudgedStack {
    ContourSet charted;                   // parallel; the z of the points of a slice is its height
    std::vector<std::uint32_t> slices;    // of the set as given, by slice of the chart
    std::vector<std::uint32_t> contours;  // of the set as given, by contour of the chart
};

// Returns parallel slices and sweeps as one stack, slices along paths as one for each path, slices about an axis as one
// all round, in which each comes several times, and of planes that cross each stack by itself (stacks_of_slices.h).
// `arrangement`: of the contours. Complexity: O(points + slices^2).
std::vector<JudgedStack> judged_stacks(const ContourSet& contours, const SliceArrangement& arrangement);

}  // namespace anatomesh
