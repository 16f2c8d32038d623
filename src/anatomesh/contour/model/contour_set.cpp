#include "anatomesh/contour/model/contour_set.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/contour/model/slice_groups.h"

namespace anatomesh {

namespace {

// The sine between normals of slices of one stack is at most this, however small the stack is.
// [1; 0 to 1; M 2026-11, set not recorded]
constexpr double most_sine = 0.01;

}  // namespace

bool is_interpolated(const ContourSet& set, std::uint32_t slice, std::uint32_t structure) {
    const std::vector<std::int32_t>& numbers = set.slices[slice].interpolated;
    return std::find(numbers.begin(), numbers.end(), set.structures[structure].number) != numbers.end();
}

bool has_interpolated(const ContourSet& set) {
    return std::any_of(set.slices.begin(), set.slices.end(),
                       [](const Slice& slice) { return !slice.interpolated.empty(); });
}

bool all_parallel(const ContourSet& set, double tolerance_mm) {
    if (set.slices.empty()) return true;
    // Turning a plane by an angle about the middle of the set moves its outermost point by at most the sine
    // of the angle times half the diagonal.
    const double reach = set.box().diagonal() / 2;
    const double bound = std::min(tolerance_mm, most_sine * reach);
    const Vec3 normal = set.slices.front().plane.normal;
    return std::all_of(set.slices.begin(), set.slices.end(), [&](const Slice& slice) {
        return length(cross(normal, slice.plane.normal)) * reach <= bound;
    });
}

double median_spacing(const ContourSet& set) {
    if (set.slices.size() < 2) return 0;
    const Vec3 normal = set.slices.front().plane.normal;
    std::vector<double> positions;
    positions.reserve(set.slices.size());
    for (const Slice& slice : set.slices) positions.push_back(dot(slice.plane.origin, normal));
    std::sort(positions.begin(), positions.end());

    // Positions that differ by rounding alone are one position.
    const double same = 1e-9 * std::max({1.0, std::abs(positions.front()), std::abs(positions.back())});
    std::vector<double> gaps;
    for (std::size_t i = 1; i < positions.size(); ++i) {
        const double gap = positions[i] - positions[i - 1];
        if (gap > same) gaps.push_back(gap);
    }
    gaps = gaps_between_groups(gaps);
    if (gaps.empty()) return 0;
    const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>((gaps.size() - 1) / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    return *middle;
}

}  // namespace anatomesh
