// parallel_filter: the numbers of a list that meet a condition.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

// Returns those of `all` for which choose(number) holds, in their order. Requires: several threads may call choose at the
// same time. Complexity: linear.
template <class Choose>
std::vector<std::uint32_t> parallel_filter(const std::vector<std::uint32_t>& all, int threads,
                                           const Choose& choose) {
    return parallel_collect<std::uint32_t>(
        all.size(), 4096, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& chosen) {
            std::copy_if(all.begin() + static_cast<std::ptrdiff_t>(first),
                         all.begin() + static_cast<std::ptrdiff_t>(last), std::back_inserter(chosen), choose);
        });
}

}  // namespace anatomesh
