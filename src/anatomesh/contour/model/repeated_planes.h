// regular_gaps: what the spacing of a stack is told from where its slices come in groups, or are given again.
#pragma once

#include <vector>

namespace anatomesh {

// Gaps between planes of a stack, in their order: which lie within a group of planes, and for the others how
// far the middles of the groups are apart that they part (a plane alone is its own middle).
struct RegularGaps {
    std::vector<bool> within;
    std::vector<double> distance;  // of those within: the gap itself
};

// A group: gaps in a row that together are less than a tenth of the gap on either side and no more than half
// a millimetre (one plane given several times), or one gap that is less than half of both (slices in pairs).
// The latter count where some pair that is not at an end of the stack has gaps alike on both sides: a slice
// more makes none, and two pairs may as well be four of many. Three slices near each other or more are no
// group: islands are drawn so. Never all gaps; the largest is in none. Requires: all > 0. Complexity: O(n),
// times the length of such rows.
RegularGaps regular_gaps(const std::vector<double>& gaps);

// The gaps of a stack that are not within groups: what its spacing is told from.
std::vector<double> usual_gaps(const std::vector<double>& gaps);

}  // namespace anatomesh
