#include "anatomesh/contour/repeated_planes.h"

#include <cstddef>

namespace anatomesh {

std::vector<bool> gaps_within_repeats(const std::vector<double>& gaps) {
    constexpr double repeated = 0.1;
    std::vector<bool> within(gaps.size(), false);
    for (std::size_t first = 0; first < gaps.size(); ++first) {
        double sum = 0;
        for (std::size_t last = first; last < gaps.size(); ++last) {
            sum += gaps[last];
            if (first > 0 && sum >= repeated * gaps[first - 1]) break;
            if (last + 1 == gaps.size() ? first == 0 : sum >= repeated * gaps[last + 1]) continue;
            for (std::size_t i = first; i <= last; ++i) within[i] = true;
        }
    }
    return within;
}

std::vector<double> usual_gaps(const std::vector<double>& gaps) {
    const std::vector<bool> within = gaps_within_repeats(gaps);
    std::vector<double> usual;
    for (std::size_t i = 0; i < gaps.size(); ++i) {
        if (!within[i]) usual.push_back(gaps[i]);
    }
    return usual;
}

}  // namespace anatomesh
