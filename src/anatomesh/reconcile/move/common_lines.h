// lead_along_common_lines: contours of several slices that run along their common line get the same vertices
// there.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct CommonLineOptions {
    // A vertex that is nearer to the common line lies on it, and two on it that are nearer to each other
    // are one. A text of two decimals rounds that much away. mm. [0, 0.1; mm; M 2026-11, set not recorded]
    double width_mm = 0.01;
};

struct CommonLineStats {
    std::uint64_t led_through = 0;  // vertices that contours were led through
    std::uint64_t moved = 0;        // onto one of another slice
    double farthest_mm = 0;         // of these
};

// A side of a drawn region may lie in the axis about which planes turn: an organ was cut in half along it,
// or its contours were closed along it. All these slices then have segments on the axis, each with
// vertices of its own. As edges of one mesh they are one line, so each contour is led through the vertices
// of the others. A vertex within the width of one of an earlier slice becomes that one. Vertices that end
// no segment along the line do not count.
//
// `pairs`: of slices whose planes cross, rising. Requires: a kept set. Guarantees: a kept set, except that
// a contour may start at another vertex. No vertex is lost or moves farther than the width, and contours
// keep their shape within it. Complexity: O(points) for each pair.
CommonLineStats lead_along_common_lines(ContourSet& set,
                                        std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs,
                                        const CommonLineOptions& options);

}  // namespace anatomesh
