#include "anatomesh/contour/planes/common_normal.h"

#include <algorithm>
#include <cmath>

namespace anatomesh {

namespace {

// Slices that lean by more against the mean have no common normal. [cosine of 30 degrees; one value; D]
constexpr double cos_30 = 0.8660254037844387;

}  // namespace

std::optional<Vec3> common_normal(const ContourSet& set) {
    if (set.slices.empty()) return std::nullopt;
    const Vec3 first = set.slices.front().plane.normal;
    Vec3 sum{};
    for (const Slice& slice : set.slices) {
        const Vec3 n = slice.plane.normal;
        sum += dot(n, first) < 0 ? -1.0 * n : n;
    }
    if (!(squared_length(sum) > 0)) return std::nullopt;
    const Vec3 mean = normalized(sum);
    const bool is_common = std::all_of(set.slices.begin(), set.slices.end(), [&](const Slice& slice) {
        return std::abs(dot(slice.plane.normal, mean)) >= cos_30;
    });
    return is_common ? std::optional(mean) : std::nullopt;
}

}  // namespace anatomesh
