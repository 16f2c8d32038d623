#include "anatomesh/slices/lines/match_intervals.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace anatomesh {

IntervalMatching match_intervals(std::span<const double> first, std::span<const double> second) {
    assert(first.size() % 2 == 0 && second.size() % 2 == 0);
    const std::size_t n = first.size(), m = second.size(), row = m + 1;
    enum class Step : std::uint8_t { none, match, drop_first, drop_second };
    constexpr double infinity = std::numeric_limits<double>::infinity();
    // best[i, j]: the first i ends against the first j; i and j have the same parity throughout.
    std::vector<double> best((n + 1) * row, infinity);
    std::vector<Step> step((n + 1) * row, Step::none);
    best[0] = 0;
    const auto take = [&](std::size_t at, double cost, Step by) {
        if (cost < best[at]) best[at] = cost, step[at] = by;
    };
    for (std::size_t i = 0; i <= n; ++i) {
        for (std::size_t j = i % 2; j <= m; j += 2) {
            const std::size_t at = i * row + j;
            if (i > 0 && j > 0)
                take(at, best[at - row - 1] + std::abs(first[i - 1] - second[j - 1]), Step::match);
            if (i > 1) take(at, best[at - 2 * row] + first[i - 1] - first[i - 2], Step::drop_first);
            if (j > 1) take(at, best[at - 2] + second[j - 1] - second[j - 2], Step::drop_second);
        }
    }
    IntervalMatching result;
    result.cost = best.back();
    for (std::size_t i = n, j = m; i + j > 0;) {
        switch (step[i * row + j]) {
            case Step::drop_first:
                i -= 2;
                result.only_first.push_back(static_cast<std::uint32_t>(i));
                break;
            case Step::drop_second:
                j -= 2;
                result.only_second.push_back(static_cast<std::uint32_t>(j));
                break;
            default:
                --i, --j;
                result.matched.emplace_back(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
        }
    }
    std::reverse(result.matched.begin(), result.matched.end());
    std::reverse(result.only_first.begin(), result.only_first.end());
    std::reverse(result.only_second.begin(), result.only_second.end());
    return result;
}

double symmetric_difference(std::span<const double> first, std::span<const double> second) {
    std::vector<double> ends(first.begin(), first.end());
    ends.insert(ends.end(), second.begin(), second.end());
    std::sort(ends.begin(), ends.end());
    // Every end of either one changes whether the two differ.
    double sum = 0;
    for (std::size_t i = 0; i + 1 < ends.size(); i += 2) sum += ends[i + 1] - ends[i];
    return sum;
}

}  // namespace anatomesh
