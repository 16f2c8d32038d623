// stacks_of_slices: the slices of a set that lie side by side, and what slices across them say of the gaps.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

struct StackOfSlices {
    Sweep sweep;
    ContourSet charted;                 // these slices in its chart coordinates and its order
    std::vector<std::uint32_t> slices;  // of the set as given, in this order
    bool leads = true;  // the field goes by this stack; else it is one of planes in any position
};

// All slices, where they are a sweep; else the stack of a set that has a few planes across it
// (crossed_field.h); else every family of four slices or more within a degree of one of them, that lie side
// by side. Nothing of planes about an axis, along paths, or in no order at all. `arrangement`:
// of the contours. Complexity: O(points + slices^2).
std::vector<StackOfSlices> stacks_of_slices(const ContourSet& contours, const SliceArrangement& arrangement);

// By structure, then by gap between two slices of the stack that follow one another: 1 where a contour on a
// slice of no part in the stack lies in the gap alone, or goes into it and back to the slice it came from.
// There a surface may do more than go on from slice to slice. A point within the tolerance of a slice lies on
// it. Complexity: O(points log slices).
std::vector<std::vector<std::uint8_t>> turns_in_gaps(const ContourSet& contours, const StackOfSlices& stack,
                                                     double tolerance_mm);

}  // namespace anatomesh
