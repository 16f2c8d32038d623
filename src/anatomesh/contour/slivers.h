// Slivers: where the contours of two structures were drawn on one line twice, and cross each other again and
// again: the narrow overlaps and gaps between one crossing and the next.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/contour/led_contours.h"

namespace anatomesh {

// Pairs (loop, vertex), in rising order: the vertex is one of another structure's contour, and beside that
// loop in a sliver. A sliver lies between two places where two contours meet (cross, or have a vertex in
// common), which follow one another along both, in opposite directions; every vertex of either stretch is
// nearer than the width, and than this share of the mean segment on either side, to the other stretch. What
// is open on one side, as the gap of a joint, is none. `at`: the vertices' places in the slice's plane.
// Requires: loops as drawn. Complexity: O(n log n + pairs of segments whose boxes meet).
std::vector<std::array<std::uint32_t, 2>> beside_in_slivers(const std::vector<LedContour>& loops,
                                                            const std::vector<Vec2>& at, double width_mm,
                                                            double share_of_segment);

}  // namespace anatomesh
