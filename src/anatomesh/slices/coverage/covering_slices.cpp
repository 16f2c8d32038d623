#include "anatomesh/slices/coverage/covering_slices.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <optional>

#include "anatomesh/base/sort_distinct.h"

namespace anatomesh {

namespace {

// Gaps are alike that differ by less than this share of the larger, because files round the positions of
// slices. [1; 0 to 1; M 2026-11 stacks with a slice more or less]
constexpr double same_spacing = 0.05;
// Fewer gaps show no spacing: two may be alike by chance.
// [gaps; >= 2; M 2026-11 organs drawn every few slices of a lesion]
constexpr std::size_t fewest_gaps = 3;
// Fewer slices show no slices of a structure's own.
// [slices; >= 3; M 2026-11 organs drawn every few slices of a lesion]
constexpr std::size_t fewest_drawn = 3;

bool alike(double a, double b) {
    return std::abs(a - b) <= same_spacing * std::max(a, b);
}

bool has_most_gaps_with_others(const std::vector<std::uint32_t>& drawn) {
    std::size_t skips = 0;
    for (std::size_t i = 1; i < drawn.size(); ++i) skips += drawn[i] - drawn[i - 1] >= 2;
    return drawn.size() >= fewest_drawn && 2 * skips > drawn.size() - 1;
}

// Whether all its gaps are as wide, whatever they hold.
bool is_even(const std::vector<std::uint32_t>& drawn, const std::vector<double>& heights) {
    if (heights.empty() || drawn.size() <= fewest_gaps) return false;
    const double first = heights[drawn[1]] - heights[drawn[0]];
    for (std::size_t i = 2; i < drawn.size(); ++i) {
        if (!alike(heights[drawn[i]] - heights[drawn[i - 1]], first)) return false;
    }
    return true;
}

// The spacing of a structure's gaps that hold no other slices, if they are even.
std::optional<double> own_spacing(const std::vector<std::uint32_t>& drawn,
                                  const std::vector<double>& heights) {
    std::vector<double> gaps;
    for (std::size_t i = 1; i < drawn.size(); ++i) {
        if (drawn[i] == drawn[i - 1] + 1) gaps.push_back(heights[drawn[i]] - heights[drawn[i - 1]]);
    }
    if (gaps.size() < fewest_gaps) return std::nullopt;
    const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>((gaps.size() - 1) / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    const double usual = *middle;
    const auto as_usual = static_cast<std::size_t>(
        std::count_if(gaps.begin(), gaps.end(), [&](double gap) { return alike(gap, usual); }));
    if (as_usual < fewest_gaps || 3 * as_usual < 2 * gaps.size()) return std::nullopt;
    return usual;
}

// Whether it is so far from one height to the other, or from slice to slice of those left out between them.
bool is_as_wide(double low, double high, double spacing, const std::vector<double>& left_out) {
    double from = low;
    for (auto at = std::upper_bound(left_out.begin(), left_out.end(), low);
         at != left_out.end() && *at < high; ++at) {
        if (!alike(*at - from, spacing)) return false;
        from = *at;
    }
    return alike(high - from, spacing);
}

}  // namespace

std::vector<std::uint32_t> covering_slices(const std::vector<std::uint32_t>& drawn,
                                           const std::vector<double>& heights,
                                           const std::vector<double>& left_out) {
    assert(!drawn.empty());
    if (has_most_gaps_with_others(drawn) || is_even(drawn, heights)) return drawn;
    const std::optional<double> spacing = !heights.empty() ? own_spacing(drawn, heights) : std::nullopt;
    std::vector<std::uint32_t> covering{drawn.front()};
    for (std::size_t i = 1; i < drawn.size(); ++i) {
        const bool is_usual =
            spacing && is_as_wide(heights[drawn[i - 1]], heights[drawn[i]], *spacing, left_out);
        for (std::uint32_t n = drawn[i - 1] + 1; n < drawn[i] && !is_usual; ++n) covering.push_back(n);
        covering.push_back(drawn[i]);
    }
    return covering;
}

std::vector<double> heights_left_out(const ContourSet& set, std::uint32_t structure, Vec3 middle, Vec3 way) {
    // A slice that was left out lies across the way if its normal keeps this cosine with it, 26 degrees;
    // others part no gap of it. [1, cosine; 0 to 1; D]
    constexpr double across = 0.9;
    std::vector<double> heights;
    if (structure >= set.structures.size()) return heights;
    for (const LeftOutSlice& slice : set.left_out) {
        const double along = dot(slice.plane.normal, way);
        if (slice.structure == set.structures[structure].number && std::abs(along) >= across * length(way))
            heights.push_back(-slice.plane.signed_distance(middle) / along);
    }
    sort_distinct(heights);
    return heights;
}

}  // namespace anatomesh
