#include "anatomesh/contour/model/slice_groups.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace anatomesh {

namespace {

// Gaps beside a group are alike if they differ by no more than this share of the larger. [1; 0 to 1; D a choice, measurement not recorded]
constexpr double alike = 0.05;

// What makes a group of a row of gaps: together they are less than a share of the gap on either side.
struct GroupRule {
    double share;
    double most_mm;         // of the row
    std::size_t most_gaps;  // in it
};
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr GroupRule repeats{0.1, 0.5, std::numeric_limits<std::size_t>::max()}, pairs{0.5, infinite, 1};

// Marks such rows; at the ends of the stack too, where asked. Whether one has gaps alike on both sides.
bool mark_rows(const std::vector<double>& gaps, const GroupRule& rule, bool at_ends,
               std::vector<bool>& within) {
    bool regular = false;
    for (std::size_t first = 0; first < gaps.size(); ++first) {
        double sum = 0;
        for (std::size_t last = first; last < gaps.size() && last - first < rule.most_gaps; ++last) {
            sum += gaps[last];
            if (sum > rule.most_mm || (first > 0 && sum >= rule.share * gaps[first - 1])) break;
            const bool is_first = first == 0, is_last = last + 1 == gaps.size();
            if (is_first && is_last) continue;
            if (!is_last && sum >= rule.share * gaps[last + 1]) continue;
            if ((is_first || is_last) && !at_ends) continue;
            for (std::size_t i = first; i <= last; ++i) within[i] = true;
            if (is_first || is_last) continue;
            const double below = gaps[first - 1], above = gaps[last + 1];
            regular |= std::abs(below - above) <= alike * std::max(below, above);
        }
    }
    return regular;
}

}  // namespace

SliceGroups find_slice_groups(const std::vector<double>& gaps) {
    SliceGroups groups{std::vector<bool>(gaps.size(), false), gaps};
    if (std::vector<bool> rows = groups.within; mark_rows(gaps, pairs, false, rows))
        mark_rows(gaps, pairs, true, groups.within);
    mark_rows(gaps, repeats, true, groups.within);
    for (std::size_t i = 0; i < gaps.size(); ++i) {
        if (groups.within[i]) continue;
        for (std::size_t k = i; k > 0 && groups.within[k - 1]; --k) groups.distance[i] += 0.5 * gaps[k - 1];
        for (std::size_t k = i + 1; k < gaps.size() && groups.within[k]; ++k)
            groups.distance[i] += 0.5 * gaps[k];
    }
    return groups;
}

std::vector<double> gaps_between_groups(const std::vector<double>& gaps) {
    const SliceGroups groups = find_slice_groups(gaps);
    std::vector<double> usual;
    for (std::size_t i = 0; i < gaps.size(); ++i) {
        if (!groups.within[i]) usual.push_back(gaps[i]);
    }
    return usual;
}

}  // namespace anatomesh
