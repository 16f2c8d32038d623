// lead_along_common_lines: contours of several slices that run along the line in which their planes meet.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct CommonLineOptions {
    // A vertex this near to the common line lies on it, and two on it as near are one: what a text of two
    // decimals rounds away. mm. [0, 0.1]
    double width_mm = 0.01;
};

struct CommonLineStats {
    std::uint64_t led_through = 0;  // vertices that contours were led through
    std::uint64_t moved = 0;        // onto one of another slice
    double farthest_mm = 0;         // of these
};

// A side of what is drawn may lie in the axis about which planes are turned: half of an organ that is cut
// along it, or contours that were closed along it. Then contours of all these slices have segments there, one
// upon the other, each with vertices of its own; as edges of one mesh they are one line, so each is led
// through the vertices of the others on it. A vertex within the width of one of an earlier slice becomes that
// one. Vertices that no segment along the line ends at do not count. `pairs`: of slices whose planes cross,
// in rising order. Requires: a kept set. Guarantees: a kept set, but that a contour may start at another
// vertex; no vertex is lost or moves farther than the width; contours keep their shape within it. Complexity:
// O(points) for each pair.
CommonLineStats lead_along_common_lines(ContourSet& set,
                                        std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs,
                                        const CommonLineOptions& options);

}  // namespace anatomesh
