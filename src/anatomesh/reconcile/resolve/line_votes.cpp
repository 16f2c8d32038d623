#include "anatomesh/reconcile/resolve/line_votes.h"

#include <algorithm>
#include <cstddef>

#include "anatomesh/reconcile/move/snap_planes_to_axis.h"

namespace anatomesh {

namespace {

// Lines in which rounded planes about an axis meet pairwise differ in direction by less.
// [1; 0 to 1; D digits of files]
constexpr double same_direction_sine = 1e-3;

bool runs_by(const Line& line, const Line& other, Vec3 place) {
    return length(cross(line.direction, other.direction)) <= same_direction_sine &&
           length(line.at(line.along(place)) - place) <= rounded_plane_mm;
}

bool is_inside(const std::vector<IntervalEndpoint>& ends, double t) {
    const auto beyond = std::upper_bound(ends.begin(), ends.end(), t,
                                         [](double at, const IntervalEndpoint& end) { return at < end.t; });
    return (beyond - ends.begin()) % 2 == 1;
}

}  // namespace

LineVotes::LineVotes(std::span<const LineComparison> comparisons) : comparisons_(comparisons) {
    std::uint32_t slices = 0;
    for (const LineComparison& one : comparisons) slices = std::max({slices, one.a + 1, one.b + 1});
    first_.assign(slices + 1, 0);
    for (const LineComparison& one : comparisons) {
        ++first_[one.a + 1];
        ++first_[one.b + 1];
    }
    for (std::uint32_t s = 0; s < slices; ++s) first_[s + 1] += first_[s];
    of_slice_.resize(2 * comparisons.size());
    std::vector<std::uint32_t> next = first_;
    for (std::uint32_t c = 0; c < comparisons.size(); ++c) {
        of_slice_[next[comparisons[c].a]++] = c;
        of_slice_[next[comparisons[c].b]++] = c;
    }
}

bool LineVotes::most_agree(const LineComparison& comparison, std::uint32_t own, double t) const {
    const Count votes = count(comparison, own, t);
    return votes.with > votes.against;
}

bool LineVotes::most_differ(const LineComparison& comparison, std::uint32_t own, double t) const {
    const Count votes = count(comparison, own, t);
    return votes.against > votes.with;
}

LineVotes::Count LineVotes::count(const LineComparison& comparison, std::uint32_t own, double t) const {
    const bool inside = is_inside(own == comparison.a ? comparison.endpoints_a : comparison.endpoints_b, t);
    const Vec3 place = comparison.line.at(t);
    Count votes;
    for (std::uint32_t n = first_[own]; n < first_[own + 1]; ++n) {
        const LineComparison& one = comparisons_[of_slice_[n]];
        if (one.structure != comparison.structure || !runs_by(one.line, comparison.line, place)) continue;
        const double there = one.line.along(place);
        // A slice has no vote beyond the part of the line that it says something of.
        const auto& [first, last] = own == one.a ? one.seen_by_b : one.seen_by_a;
        if (!(there >= first && there <= last)) continue;
        if (is_inside(own == one.a ? one.endpoints_a : one.endpoints_b, there) != inside) continue;
        ++(is_inside(own == one.a ? one.endpoints_b : one.endpoints_a, there) == inside ? votes.with
                                                                                        : votes.against);
    }
    return votes;
}

}  // namespace anatomesh
