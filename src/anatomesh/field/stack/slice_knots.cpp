#include "anatomesh/field/stack/slice_knots.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

#include "anatomesh/contour/model/slice_groups.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/coverage/covering_slices.h"
#include "anatomesh/slices/coverage/few_slices.h"

namespace anatomesh {

namespace {

double lower_median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// Gaps are alike that differ by less than this share of the larger, because files round the positions of
// slices. [1; 0 to 1; M 2026-11 stacks with a slice more or less]
constexpr double same_spacing = 0.05;

// Gaps are joined up to this multiple of what is asked for: two spacings of slices that lean, or whose places
// were rounded, are a little more than twice one. [1; >= 1; M 2026-11 a slice left out in a sweep of nine]
constexpr double joined_more = 1.02;
// A wider gap that is joined is told of: half a slice more than usual is no rounding. [spacings; > 1; C]
constexpr double hardly_wider = 1.5;
// A structure whose thickness is known ends before the next slice where its half is less than this share of that gap.
// [gaps; 1 to 2; D ends at 0.95 of the gap]
constexpr double ends_before_next = 1.9;
// Of uneven gaps none above this multiple of their median is usual.
// [median gaps; > 1; M 2026-11 liver, vertebra and spleen by slices 1.5 to 6 mm apart]
constexpr double most_uneven = 2;

// The spacing that most of a few neighbouring gaps share, from an end inwards, one slice left out where that
// makes more of them alike; of several as good that of the gap nearest to the end, or nothing. So neither one
// slice more nor one less moves it, and where the spacing changes before the end, that beside it counts.
std::optional<double> shared_spacing(const std::vector<double>& gaps) {
    std::optional<double> best;
    // How many gaps are odd, whether a slice was left out, and which gap is the first that is not odd.
    std::tuple<std::size_t, bool, std::size_t> least{gaps.size(), false, 0};
    for (std::size_t extra = 0; extra < gaps.size(); ++extra) {
        std::vector<double> left = gaps;
        if (extra > 0) {  // the slice before this gap
            left[extra - 1] += left[extra];
            left.erase(left.begin() + static_cast<std::ptrdiff_t>(extra));
        }
        for (std::size_t n = 0; n < left.size(); ++n) {
            const auto alike =
                static_cast<std::size_t>(std::count_if(left.begin(), left.end(), [&](double gap) {
                    return std::abs(gap - left[n]) <= same_spacing * std::max(gap, left[n]);
                }));
            const std::tuple key{left.size() - alike + (extra > 0 ? 1 : 0), extra > 0, n};
            if (alike < 2 || 2 * alike <= left.size() || !(key < least)) continue;
            least = key;
            best = left[n];
        }
    }
    return best;
}

// Two in three of them, three at least, are as their lower median; or there are less than three.
bool are_even(const std::vector<double>& distances) {
    if (distances.size() < 3) return true;
    const double usual = lower_median(distances);
    const auto alike = std::count_if(distances.begin(), distances.end(), [&](double d) {
        return std::abs(d - usual) <= same_spacing * std::max(d, usual);
    });
    return alike >= 3 && 3 * static_cast<std::size_t>(alike) >= 2 * distances.size();
}

// Of uneven gaps that in which any place lies, in the mean: it lies the more often in one the wider that is
// (renewal theory: Feller, An Introduction to Probability Theory and Its Applications II, 1971, chapter I.4).
double spacing_round_a_place(const std::vector<double>& gaps) {
    double sum = 0, squares = 0;
    for (const double gap : gaps) {
        sum += gap;
        squares += gap * gap;
    }
    return squares / sum;
}

// The gaps between slices that tell of a structure, and what is usual among them. Slices in groups, and
// planes given again, count once; what is a group the whole stack tells.
class GapClassification {
  public:
    // `around`: the gaps of the stack; those from `first` on, `count` of them, are the structure's.
    // `spacing`: where these tell none.
    GapClassification(const std::vector<double>& around, std::size_t first, std::size_t count, double spacing)
        : spacing_(spacing) {
        const SliceGroups groups = find_slice_groups(around);
        for (std::size_t i = 0; i < around.size(); ++i) {
            if (i == first) stack_before_ = stack_distances_.size();
            if (!groups.within[i]) stack_distances_.push_back(groups.distance[i]);
        }
        for (std::size_t i = first; i < first + count; ++i) {
            place_.push_back(usual_.size());
            all_.push_back(around[i]);
            distances_.push_back(groups.distance[i]);
            counts_.push_back(!groups.within[i]);
            if (!counts_.back()) continue;
            usual_.push_back(all_.back());
            usual_distances_.push_back(distances_.back());
        }
    }

    std::size_t size() const { return all_.size(); }
    double operator[](std::size_t i) const { return all_[i]; }
    bool counts(std::size_t i) const { return counts_[i]; }

    // Lower median of the gaps that count within three of gap i: one missing slice does not move it, a change
    // of spacing does.
    double local_spacing(std::size_t i) const { return local(usual_, place_[i]); }
    // The same of all gaps, those within groups too.
    double spacing_without_groups(std::size_t i) const { return local(all_, i); }
    // How many times as far the middles of what gap i parts are from each other as is usual there.
    double spacings_if_even(std::size_t i) const {
        return distances_[i] / local(usual_distances_, place_[i]);
    }
    // Where gaps are uneven, a wide one is no missing slice yet: there usual is what three in four of more of
    // them do not exceed, if that is more, but no more than twice: slices far apart tell nothing of others
    // near each other.
    double spacings(std::size_t i) const {
        const double usual = local(usual_distances_, place_[i]);
        if (!counts_[i] || are_even(others_within(3, i))) return spacings_if_even(i);
        std::vector<double> more = others_within(8, i);
        const auto quartile = more.begin() + static_cast<std::ptrdiff_t>((3 * more.size() + 3) / 4 - 1);
        std::nth_element(more.begin(), quartile, more.end());
        return distances_[i] / std::clamp(*quartile, usual, most_uneven * usual);
    }

  private:
    // The distances of the stack that count on either side of gap i, so many of them.
    std::vector<double> others_within(std::size_t reach, std::size_t i) const {
        const std::size_t at = stack_before_ + place_[i], first = at < reach ? 0 : at - reach,
                          last = std::min(stack_distances_.size(), at + reach + 1);
        std::vector<double> others(stack_distances_.begin() + static_cast<std::ptrdiff_t>(first),
                                   stack_distances_.begin() + static_cast<std::ptrdiff_t>(last));
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(at - first));
        return others;
    }

    double local(const std::vector<double>& of, std::size_t place) const {
        if (of.empty()) return spacing_;
        const std::size_t at = std::min(place, of.size() - 1);
        const std::size_t first = at < 3 ? 0 : at - 3, last = std::min(of.size(), at + 4);
        return lower_median({of.begin() + static_cast<std::ptrdiff_t>(first),
                             of.begin() + static_cast<std::ptrdiff_t>(last)});
    }

    double spacing_;
    std::vector<double> all_, distances_, usual_, usual_distances_;
    std::vector<double> stack_distances_;  // of all gaps of the stack that count
    std::size_t stack_before_ = 0;         // of these, before the structure's
    std::vector<bool> counts_;
    std::vector<std::size_t> place_;  // in usual_, of each gap or the next one that counts
};

}  // namespace

namespace {

std::vector<std::uint32_t> covering_of(const std::vector<SliceInterval>& intervals,
                                       const std::vector<std::uint32_t>& drawn, bool every_slice,
                                       const std::vector<double>& left_out) {
    if (every_slice) {
        std::vector<std::uint32_t> all(drawn.back() - drawn.front() + 1);
        std::iota(all.begin(), all.end(), drawn.front());
        return all;
    }
    std::vector<double> heights;
    for (const SliceInterval& interval : intervals) heights.push_back(middle(interval));
    return covering_slices(drawn, heights, left_out);
}

// Of those that heights, rising, part a gap into, as a share of it.
double widest_part(double low, double high, const std::vector<double>& heights) {
    double from = low, widest = 0;
    for (auto at = std::upper_bound(heights.begin(), heights.end(), low); at != heights.end() && *at < high;
         ++at) {
        widest = std::max(widest, *at - from);
        from = *at;
    }
    return high > low ? std::max(widest, high - from) / (high - low) : 1;
}

bool has_part(const std::vector<StructurePart>& parts, double low, double high) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const StructurePart& part) { return part.low <= low && high <= part.high; });
}

// The least of parts that begin with the slice, or, where it is not inward upwards, end with it.
std::optional<double> spacing_of_parts(const std::vector<StructurePart>& parts, const SliceInterval& slice,
                                       int inward) {
    std::optional<double> least;
    for (const StructurePart& part : parts) {
        const double spacing = inward > 0 ? part.below : part.above;
        if ((inward > 0 ? part.low == slice.low : part.high == slice.high) &&
            spacing < least.value_or(HUGE_VAL))
            least = spacing;
    }
    return least;
}

// The slices that tell of a structure, as indices into the intervals, rising.
struct TellingSlices {
    std::vector<std::uint32_t> covering;  // that say something of it
    // Of these, without those whose outlines nobody drew: such part no gap, those between the others count.
    std::vector<std::uint32_t> known;
    std::vector<std::size_t> place;  // in `known`, of each that tells, or of the next one below it
    bool own_spacing = false;        // it is on slices of its own, and knows these alone
};

TellingSlices telling_slices(const std::vector<SliceInterval>& intervals,
                             const std::vector<std::uint32_t>& drawn, bool every_slice,
                             const GapEvidence& evidence) {
    TellingSlices slices;
    slices.covering = covering_of(intervals, drawn, every_slice, evidence.left_out);
    slices.own_spacing = slices.covering.size() < drawn.back() - drawn.front() + 1u;
    for (const std::uint32_t i : slices.covering) {
        const bool is_end = i == slices.covering.front() || i == slices.covering.back();
        if (is_end || !std::binary_search(evidence.interpolated.begin(), evidence.interpolated.end(), i))
            slices.known.push_back(i);
        slices.place.push_back(slices.known.size() - 1);
    }
    return slices;
}

GapClassification gaps_between(const TellingSlices& slices, const std::vector<SliceInterval>& intervals,
                               double spacing) {
    const auto gap_between = [&](std::size_t below, std::size_t above) {
        return intervals[above].low - intervals[below].high;
    };
    const std::vector<std::uint32_t>& known = slices.known;
    const bool own_gaps = slices.own_spacing || known.size() < slices.covering.size();
    std::vector<double> around;
    if (own_gaps) {
        for (std::size_t i = 1; i < known.size(); ++i) around.push_back(gap_between(known[i - 1], known[i]));
    } else {
        for (std::size_t i = 1; i < intervals.size(); ++i) around.push_back(gap_between(i - 1, i));
    }
    return {around, own_gaps ? 0 : slices.covering.front(), known.size() - 1, spacing};
}

// Makes the knots from the lowest slice upwards, part by part.
class KnotMaker {
  public:
    // `spacing`: where the gaps tell none.
    KnotMaker(const std::vector<SliceInterval>& intervals, TellingSlices slices, bool every_slice,
              double spacing, const FieldOptions& options, const GapEvidence& evidence)
        : intervals_(intervals),
          options_(options),
          evidence_(evidence),
          slices_(std::move(slices)),
          gaps_(gaps_between(slices_, intervals, spacing)),
          spacing_(spacing),
          widest_(options.max_gap_spacings * joined_more),
          nearest_to_end_((every_slice ? options.max_gap_spacings : hardly_wider) * joined_more) {}

    StructureKnots make(const std::vector<std::uint32_t>& drawn) {
        const std::vector<std::uint32_t>& covering = slices_.covering;
        for (std::uint32_t i = drawn.front(); i <= drawn.back(); ++i) {
            if (!std::binary_search(covering.begin(), covering.end(), i))
                made_.unknown.push_back(intervals_[i].slice);
        }
        std::size_t next_drawn = 0;
        for (std::size_t i = 0; i < covering.size(); ++i) {
            if (i > 0 && slices_.place[i] != slices_.place[i - 1]) pass_gap(i);
            if (i == 0) made_.knots.push_back(end_knot(covering[0], -1, spacing_at(0, 1)));
            const bool is_drawn = next_drawn < drawn.size() && drawn[next_drawn] == covering[i];
            if (i > 0 && is_drawn != (next_drawn > 0 && drawn[next_drawn - 1] == covering[i - 1]))
                end_within_gap(covering[i - 1], covering[i], is_drawn);
            next_drawn += is_drawn;
            add_slice(covering[i], is_drawn);
        }
        close_part(end_knot(covering.back(), 1, spacing_at(slices_.known.size() - 1, -1)));
        made_.flat.back().until = std::numeric_limits<double>::infinity();
        return std::move(made_);
    }

  private:
    double spacings(std::size_t gap) const {
        return evidence_.thickness > 0 ? gaps_[gap] / evidence_.thickness : gaps_.spacings(gap);
    }

    // Where its own slices were left out, of usual gaps, it goes on.
    bool is_open(std::size_t gap) const {
        const double spacings = this->spacings(gap);
        const double low = intervals_[slices_.known[gap]].high, high = intervals_[slices_.known[gap + 1]].low;
        return spacings > widest_ && spacings * widest_part(low, high, evidence_.left_out) > hardly_wider &&
               !(evidence_.of_all && has_part(evidence_.parts, low, high));
    }

    // The gaps that count from a known slice inwards, up to eight, before the first open one.
    std::vector<double> gaps_from(std::size_t end, int inward) const {
        std::vector<double> more;
        for (std::size_t i = 0; more.size() < 8; ++i) {
            const std::size_t gap = inward > 0 ? end + i : end - 1 - i;
            if (gap >= gaps_.size() || is_open(gap)) break;
            if (gaps_.counts(gap)) more.push_back(gaps_[gap]);
        }
        return more;
    }

    // Spacing where a part begins or ends: the one that most of its gaps there share. Where they share none,
    // and more of them are uneven too, that of the gap that an end falls into. Else the local one, or that of
    // the part itself where it is smaller.
    double spacing_at(std::size_t end, int inward) const {
        const SliceInterval& slice = intervals_[slices_.known[end]];
        if (const auto told = spacing_of_parts(evidence_.parts, slice, inward)) return *told;
        if (evidence_.thickness > 0) return evidence_.thickness;
        if (gaps_.size() == 0) return spacing_;
        const std::vector<double> more = gaps_from(end, inward);
        std::vector<double> own(more.begin(), more.begin() + std::min<std::ptrdiff_t>(4, std::ssize(more)));
        if (const std::optional<double> shared = shared_spacing(own)) return *shared;
        if (more.size() > 4 && !are_even(more))
            return std::min(spacing_round_a_place(more), most_uneven * lower_median(own));
        const std::size_t beside =
            inward > 0 ? std::min(end, gaps_.size() - 1) : std::max<std::size_t>(end, 1) - 1;
        const double local = gaps_.local_spacing(beside);
        return own.empty() ? local : std::min(local, lower_median(std::move(own)));
    }

    // Beyond the outermost ends: the next slice of the set where it says something and is near, else an empty
    // knot one spacing away.
    SliceKnot end_knot(std::uint32_t at, int direction, double local) const {
        const double z = direction > 0 ? intervals_[at].high + local : intervals_[at].low - local;
        const SliceKnot alone{z, z, SliceKnot::no_slice};
        if (slices_.own_spacing) return alone;
        const SliceInterval* next = next_slice(at, direction);
        if (next == nullptr) return alone;
        const double gap = direction > 0 ? next->low - intervals_[at].high : intervals_[at].low - next->high;
        const double low = std::min(intervals_[at].high, next->high), high = low + gap;
        const bool goes_on = has_part(evidence_.parts, low, high);
        // As thick as it is known to be, it may end before the next slice.
        const bool ends_before =
            evidence_.thickness > 0 ? local <= ends_before_next * gap : gap > nearest_to_end_ * local;
        return ends_before && !goes_on ? alone : SliceKnot{next->low, next->high, SliceKnot::no_slice};
    }

    // The next slice of the set beyond an end; where a thickness is known, those nearer than few_slices.h says are on
    // the same plane as good as. Null: none.
    const SliceInterval* next_slice(std::uint32_t at, int direction) const {
        const double same_plane = same_plane_share * evidence_.thickness;
        for (std::int64_t n = std::int64_t{at} + direction; n >= 0 && n < std::ssize(intervals_);
             n += direction) {
            const SliceInterval& next = intervals_[static_cast<std::size_t>(n)];
            const double gap =
                direction > 0 ? next.low - intervals_[at].high : intervals_[at].low - next.high;
            if (gap > same_plane) return &next;
        }
        return nullptr;
    }

    void add_slice(std::uint32_t at, bool is_drawn) {
        const SliceInterval& interval = intervals_[at];
        made_.knots.push_back({interval.low, interval.high, is_drawn ? interval.slice : SliceKnot::no_slice});
        if (is_drawn) {
            part_.push_back(at);
        } else {
            made_.not_drawn.push_back(interval.slice);
        }
    }

    void close_part(const SliceKnot& end) {
        StructureKnots::Extent extent;
        if (options_.caps == EndCaps::flat && part_.size() > 1) {
            extent.low = intervals_[part_.front()].low;
            extent.high = intervals_[part_.back()].high;
        }
        made_.flat_island |= options_.caps == EndCaps::flat && part_.size() == 1;
        part_.clear();
        made_.knots.push_back(end);
        extent.until = made_.knots.back().high;
        made_.flat.push_back(extent);
    }

    // One of the two slices draws it, the upper one if `is_upper`: it ends as far from that as its slices are thick,
    // where the other one, which is empty, is further away.
    void end_within_gap(std::uint32_t below, std::uint32_t above, bool is_upper) {
        const double low = intervals_[below].high, high = intervals_[above].low,
                     thickness = evidence_.thickness;
        if (!(thickness > 0) || high - low <= joined_more * thickness) return;
        const double end = is_upper ? high - thickness : low + thickness;
        if (end > made_.knots.back().high) made_.knots.push_back({end, end, SliceKnot::no_slice});
    }

    // The gap below covering slice i: an open one ends a part and begins another; a wide one is told of.
    void pass_gap(std::size_t i) {
        const std::size_t g = slices_.place[i - 1];
        const double gap = gaps_[g];
        const SliceInterval &below_gap = intervals_[slices_.known[g]],
                            &above_gap = intervals_[slices_.covering[i]];
        const SliceGap ends{below_gap.high, above_gap.low, below_gap.slice, above_gap.slice};
        if (is_open(g) && slices_.known[g] == slices_.covering[i - 1]) {
            made_.open_gaps.push_back(ends);
            // The two empty knots in the gap do not pass one another.
            const double below = ends.low + std::min(spacing_at(g, -1), 0.5 * gap);
            const double above = std::max(ends.high - std::min(spacing_at(g + 1, 1), 0.5 * gap), below);
            close_part({below, below, SliceKnot::no_slice});
            made_.knots.push_back({above, above, SliceKnot::no_slice});
        } else if (spacings(g) > hardly_wider || gaps_.spacings_if_even(g) > widest_) {
            made_.bridged_gaps.push_back(ends);
        } else if (gaps_.spacing_without_groups(g) < gaps_.local_spacing(g) &&
                   gap > widest_ * gaps_.spacing_without_groups(g)) {
            made_.gaps_by_groups.push_back(ends);
        }
    }

    const std::vector<SliceInterval>& intervals_;
    const FieldOptions& options_;
    const GapEvidence& evidence_;
    TellingSlices slices_;
    GapClassification gaps_;
    double spacing_;
    double widest_;  // gap that is joined, in spacings
    // A slice beyond an end that is further away, in spacings, says nothing of how far it goes: if slices say all, one is
    // missing there; else it would be drawn on the one between.
    double nearest_to_end_;
    StructureKnots made_;
    std::vector<std::uint32_t> part_;  // the drawn slices of the part at hand
};

}  // namespace

StructureKnots structure_knots(const std::vector<SliceInterval>& intervals,
                               const std::vector<std::uint32_t>& drawn, bool every_slice, double spacing,
                               const FieldOptions& options, const GapEvidence& evidence) {
    assert(!drawn.empty() && spacing > 0);
    TellingSlices slices = telling_slices(intervals, drawn, every_slice, evidence);
    return KnotMaker(intervals, std::move(slices), every_slice, spacing, options, evidence).make(drawn);
}

double mean_thickness(const StructureKnots& knots) {
    const std::vector<SliceKnot>& all = knots.knots;
    double sum = 0;
    int drawn = 0;
    for (std::size_t n = 1; n + 1 < all.size(); ++n) {
        if (all[n].slice == SliceKnot::no_slice) continue;
        sum += 0.5 * (all[n].low - all[n - 1].high + all[n + 1].low - all[n].high);
        ++drawn;
    }
    return drawn > 0 ? sum / drawn : 0;
}

std::vector<StructurePart> parts_of(const StructureKnots& knots) {
    // Two empty knots part them.
    std::vector<StructurePart> parts;
    const std::vector<SliceKnot>& all = knots.knots;
    std::size_t begin = 0;
    const auto add = [&](std::size_t end) {
        const SliceKnot &first = all[begin + 1], &last = all[end - 1];
        parts.push_back({first.low, last.high, first.low - all[begin].high, all[end].low - last.high});
    };
    for (std::size_t gap = 0; gap < knots.open_gaps.size(); ++gap) {
        std::size_t end = begin + 1;
        while (all[end].high <= knots.open_gaps[gap].low) ++end;
        add(end);
        begin = end + 1;
    }
    add(all.size() - 1);
    return parts;
}

}  // namespace anatomesh
