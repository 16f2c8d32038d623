// gaps_within_repeats: planes of a stack that were given again a little off themselves.
#pragma once

#include <vector>

namespace anatomesh {

// Whether a gap lies between planes that are one given several times: gaps in a row that together are less
// than a tenth of the gap on either side. Never all of them; the largest is none. `gaps`: between the planes
// of a stack in their order, all > 0. Complexity: O(n), times the length of such rows.
std::vector<bool> gaps_within_repeats(const std::vector<double>& gaps);

// The gaps of a stack without those: what its spacing is told from.
std::vector<double> usual_gaps(const std::vector<double>& gaps);

}  // namespace anatomesh
