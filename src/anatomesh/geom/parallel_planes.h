// ParallelPlanes: planes of one normal, and where a point lies among them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "anatomesh/geom/plane.h"

namespace anatomesh {

struct ParallelPlanes {
    Plane frame;                  // of their normal
    std::vector<double> heights;  // above it, rising; mm

    // 2 k + 1 for a point that is within the tolerance of the k-th plane, 2 k for one below that and above
    // the one before. O(log planes).
    std::uint32_t level(Vec3 p, double tolerance_mm) const {
        const double height = frame.signed_distance(p);
        const auto above = static_cast<std::uint32_t>(
            std::lower_bound(heights.begin(), heights.end(), height) - heights.begin());
        if (above < heights.size() && heights[above] - height <= tolerance_mm) return 2 * above + 1;
        if (above > 0 && height - heights[above - 1] <= tolerance_mm) return 2 * above - 1;
        return 2 * above;
    }
};

}  // namespace anatomesh
