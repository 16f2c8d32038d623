// match_intervals: which end of a region on a line is which end of another drawing of it.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace anatomesh {

struct IntervalMatching {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> matched;  // (end of first, end of second), rising
    // Ends without counterpart come in neighbouring pairs, an interval or a gap that the other does not have:
    // the index of the first of the two.
    std::vector<std::uint32_t> only_first, only_second;
    double cost = 0;  // sum of distances of matched ends and of widths of what has no counterpart, mm
};

// The ends of a union of intervals on a line, ascending: entering at even indices, leaving at odd ones. The
// matching keeps the order, joins only ends of the same kind, and is the cheapest one. O(n m). Requires: even
// counts.
IntervalMatching match_intervals(std::span<const double> first, std::span<const double> second);

// Length of the symmetric difference of the two unions of intervals. O(n + m). Requires: as above.
double symmetric_difference(std::span<const double> first, std::span<const double> second);

}  // namespace anatomesh
