// LineVotes: what most of the slices that meet in one line say of a place on it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

class LineVotes {
  public:
    // Requires: the comparisons outlive this and stay as they are.
    explicit LineVotes(std::span<const LineComparison> comparisons);

    // Whether the comparison's slice `own` says of the structure at `t` on its line (inside or outside) what
    // more of the slices through that line say than say the other; those that say nothing there do not count.
    // Never so with two slices. Slices whose lines run by within 0.05 mm there, as rounded planes' do, count.
    // Requires: `own` has ends on the line: two slices without have no comparison and do not count for each
    // other. Complexity: O(comparisons of `own`).
    bool most_agree(const LineComparison& comparison, std::uint32_t own, double t) const;

  private:
    std::span<const LineComparison> comparisons_;
    std::vector<std::uint32_t> first_, of_slice_;  // of slice s: of_slice_[first_[s], first_[s + 1])
};

}  // namespace anatomesh
