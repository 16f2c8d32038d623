// find_slice_groups: which slices of a stack come in groups, or are given several times (gap clustering).
#pragma once

#include <vector>

namespace anatomesh {

// The gaps between planes of a stack, in their order.
struct SliceGroups {
    std::vector<bool> within;  // whether the gap lies within a group of planes
    // The distance between the middles of the two groups beside a gap; a plane alone is its own middle. For a gap
    // within a group this is the gap itself.
    std::vector<double> distance;
};

// There are two kinds of groups:
// - One plane given several times: gaps in a row that together are less than a tenth of the gap on either side, and
//   no more than half a millimetre.
// - Slices in pairs: one gap that is less than half of both gaps beside it. Pairs count only where a pair within
//   the stack has gaps alike on both sides, because one more slice makes no pairs.
// Three slices near each other, or more, are no group, because islands are drawn so. Guarantees: the largest gap is
// in no group. Requires: all gaps > 0. Complexity: O(n), times the length of such rows.
SliceGroups find_slice_groups(const std::vector<double>& gaps);

// Returns the gaps of a stack that are not within groups; its spacing is their median. Complexity: as above.
std::vector<double> gaps_between_groups(const std::vector<double>& gaps);

}  // namespace anatomesh
