// ParallelPlanes: planes of one normal, and the place of a point among them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "anatomesh/geom/plane.h"

namespace anatomesh {

struct ParallelPlanes {
    Plane frame;                  // has their normal
    std::vector<double> heights;  // above it, rising; mm

    // Returns how many planes lie below the height. O(1) where the planes are nearly even, else O(log planes).
    std::uint32_t count_below(double height) const {
        // Farther from the guess than this bisection is faster. [planes; > 0; B]
        constexpr std::uint32_t most_steps = 8;
        const auto count = static_cast<std::uint32_t>(heights.size());
        if (count == 0) return 0;
        // The guess takes the planes as even; two comparisons of heights prove it or lead on.
        const double even = 1 + (height - heights.front()) / (heights.back() - heights.front()) * (count - 1);
        std::uint32_t below = even > 0 ? (even < count ? static_cast<std::uint32_t>(even) : count) : 0;
        std::uint32_t steps = 0;
        for (; steps < most_steps && below > 0 && heights[below - 1] >= height; ++steps) --below;
        for (; steps < most_steps && below < count && heights[below] < height; ++steps) ++below;
        if (steps < most_steps) return below;
        return static_cast<std::uint32_t>(std::lower_bound(heights.begin(), heights.end(), height) -
                                          heights.begin());
    }

    // Returns 2 k + 1 for a point within the tolerance of the k-th plane, and 2 k for one below it and above the plane
    // before. Complexity: as count_below().
    std::uint32_t level(Vec3 p, double tolerance_mm) const {
        const double height = frame.signed_distance(p);
        const std::uint32_t above = count_below(height);
        if (above < heights.size() && heights[above] - height <= tolerance_mm) return 2 * above + 1;
        if (above > 0 && height - heights[above - 1] <= tolerance_mm) return 2 * above - 1;
        return 2 * above;
    }
};

}  // namespace anatomesh
