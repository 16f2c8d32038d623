// stack_and_crossing: a stack or sweep of slices, and a few others that run across it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Slices by their index.
struct StackAndCrossing {
    std::vector<std::uint32_t> stack;     // parallel, or a sweep
    std::vector<std::uint32_t> crossing;  // the others
};

// The slices as a stack and a few others that run across it or lean too much: the long axis beside the short
// axes of a heart, a plane of a sweep that crosses the one before. As long as the boxes of two slices'
// contours cross, or nearly so, the slice that does so with most others is taken out. Nothing where what is
// left is no stack or sweep, has fewer than four slices or fewer than three times as many as were taken out,
// or misses a structure; and nothing for an exclusive set of several structures. Complexity: O(points +
// slices^2).
std::optional<StackAndCrossing> stack_and_crossing(const ContourSet& set);

}  // namespace anatomesh
