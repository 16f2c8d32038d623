// LineVotes: the majority of the slices that meet in one line, for a place on it.
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

    // Returns whether slice `own` of the comparison agrees with the majority about the structure at `t` on
    // its line, inside or outside. Of the slices through that line those that say nothing there do not
    // count; two slices alone have no majority. Slices whose lines pass within 0.05 mm there count, as
    // those of rounded planes do. Requires: `own` has endpoints on the line, because two slices without
    // any have no comparison and do not count for each other. Complexity: O(comparisons of `own`).
    bool most_agree(const LineComparison& comparison, std::uint32_t own, double t) const;

    // Returns whether slice `own` contradicts the majority there. Otherwise as most_agree().
    bool most_differ(const LineComparison& comparison, std::uint32_t own, double t) const;

  private:
    struct Count {
        std::size_t with = 1, against = 0;
    };
    Count count(const LineComparison& comparison, std::uint32_t own, double t) const;

    std::span<const LineComparison> comparisons_;
    std::vector<std::uint32_t> first_, of_slice_;  // of slice s: of_slice_[first_[s], first_[s + 1])
};

}  // namespace anatomesh
