#include "anatomesh/reconcile/resolve/resolve_conflicting_intervals.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "anatomesh/reconcile/move/movement_nodes.h"
#include "anatomesh/reconcile/resolve/edit_region.h"
#include "anatomesh/reconcile/resolve/line_votes.h"
#include "anatomesh/reconcile/resolve/nearest_arc.h"

namespace anatomesh {

namespace {

// Each change needs a comparison of all slices. [changes; > 0; B]
constexpr std::size_t most_edits = 200;
// So does each try. [tries; > 0; B]
constexpr std::size_t most_tries = 1000;
// A change that is more times larger than its interval, or than the clearance, would make a spike.
// [1; >= 1; M 2026-11 140 random sets with stacks]
constexpr double most_times = 3;
// Shorter intervals are left: contours would get segments as short, and cells of that size.
// [mm; > 0; M 2026-11 140 random sets with stacks]
constexpr double least_interval_length_mm = 0.01;
// By this share of an interval slices have to differ less after a change. [1; 0 to 1; M 2026-11 140 random
// sets with stacks]
constexpr double least_edit_gain = 0.5;
// Slices that differ by less on their line do not contradict each other. [mm; > 0; M 2026-11 140 random sets
// with stacks]
constexpr double least_difference_mm = 0.1;

// Where an interval begins or ends on its line.
struct IntervalEnd {
    double t = 0;
    Vec3 at;
    bool of_a = false;   // of slice a's contour, or b's
    double room_mm = 0;  // to the next end beyond it, of either slice
};

struct ConflictingInterval {
    std::uint32_t a = 0, b = 0, structure = 0;
    Line line;
    IntervalEnd low, high;
    bool in_a = false;  // inside on slice a, outside on b; or the other way round
    double length_mm() const { return high.t - low.t; }
    double middle() const { return 0.5 * (low.t + high.t); }
};

std::vector<ConflictingInterval> conflicting_intervals_of(const LineComparison& c) {
    std::vector<IntervalEnd> ends;
    for (const IntervalEndpoint& end : c.endpoints_a) ends.push_back({end.t, end.at, true, 0});
    for (const IntervalEndpoint& end : c.endpoints_b) ends.push_back({end.t, end.at, false, 0});
    std::sort(ends.begin(), ends.end(), [](const IntervalEnd& p, const IntervalEnd& q) {
        return p.t != q.t ? p.t < q.t : p.of_a > q.of_a;
    });
    std::vector<ConflictingInterval> intervals;
    bool in_a = false, in_b = false;
    for (std::size_t n = 0; n + 1 < ends.size(); ++n) {
        (ends[n].of_a ? in_a : in_b) ^= true;
        if (in_a == in_b || ends[n + 1].t - ends[n].t <= least_interval_length_mm) continue;
        ConflictingInterval interval{c.a, c.b, c.structure, c.line, ends[n], ends[n + 1], in_a};
        constexpr double infinity = std::numeric_limits<double>::infinity();
        interval.low.room_mm = n > 0 ? ends[n].t - ends[n - 1].t : infinity;
        interval.high.room_mm = n + 2 < ends.size() ? ends[n + 2].t - ends[n + 1].t : infinity;
        intervals.push_back(interval);
    }
    return intervals;
}

// A change of one slice that resolves an interval.
struct IntervalEdit {
    std::uint32_t slice = 0, other = 0;
    bool inside = false;
    double farthest_mm = std::numeric_limits<double>::infinity();
    std::vector<EditedRing> rings;
};

// Makes the changes by which a slice comes to have on an interval what the other one has.
class IntervalEdits {
  public:
    IntervalEdits(const ContourSet& set, const ConflictingInterval& interval, bool of_a,
                  const ConflictingIntervalOptions& options)
        : set_(set),
          interval_(interval),
          slice_(of_a ? interval.a : interval.b),
          other_(of_a ? interval.b : interval.a),
          inside_(of_a != interval.in_a),
          of_a_(of_a),
          options_(options) {}

    void add_to(std::vector<IntervalEdit>& all) {
        const std::vector<std::vector<Vec3>> strip{beside_the_line()};
        const std::optional<std::vector<EditedRing>> narrow =
            edit_region(set_, {slice_, interval_.structure, inside_, strip, {}});
        if (narrow) {
            add(*narrow, all);
            add_without_cut_off(*narrow, all);
        }
        if (interval_.low.of_a == of_a_ && interval_.high.of_a == of_a_) return;
        const NearestArc arc = nearest_arc(set_, slice_, interval_.structure, interval_.line,
                                           set_.slices[other_].plane, interval_.low.t, interval_.high.t);
        if (arc.empty()) return;
        const std::vector<std::vector<Vec3>> regions{strip.front(), up_to(arc)};
        if (regions.back().size() < 3) return;
        if (auto rings = edit_region(set_, {slice_, interval_.structure, inside_, regions, arc.places}))
            add(std::move(*rings), all);
    }

    // Adds a change of the strip beside the line alone, for where no contour is near enough to come there.
    void add_lone_to(std::vector<IntervalEdit>& all) {
        const std::vector<std::vector<Vec3>> regions{beside_the_line()};
        std::optional<std::vector<EditedRing>> rings =
            edit_region(set_, {slice_, interval_.structure, inside_, regions, {}});
        const double half = 0.5 * interval_.length_mm();
        if (rings && interval_.length_mm() <= options_.most_parted_mm)
            all.push_back({slice_, other_, inside_, half, std::move(*rings)});
    }

  private:
    void add(std::vector<EditedRing> rings, std::vector<IntervalEdit>& all) const {
        if (rings.size() != set_.slices[slice_].contour_count &&
            interval_.length_mm() > options_.most_parted_mm)
            return;
        const double farthest = farthest_change(set_, slice_, rings);
        const double most =
            std::min(options_.most_mm, most_times * std::max(interval_.length_mm(), options_.clearance_mm));
        if (farthest <= most) all.push_back({slice_, other_, inside_, farthest, std::move(rings)});
    }

    // Adds changes in which what was cut off is removed, or filled.
    void add_without_cut_off(const std::vector<EditedRing>& narrow, std::vector<IntervalEdit>& all) const {
        const ContourSet edited = with_edited(set_, slice_, narrow);
        for (const EditedRing& ring : narrow) {
            if (!ring.is_new || ring.structure != interval_.structure) continue;
            const std::vector<std::vector<Vec3>> region{ring.points};
            if (auto rings = edit_region(edited, {slice_, interval_.structure, inside_, region, {}}))
                add(std::move(*rings), all);
        }
    }

    // Returns a strip along the interval. It goes on a little beyond an end of the slice's own contour,
    // and narrows to a point at an end of the other slice's contour.
    std::vector<Vec3> beside_the_line() const {
        const bool from_own = interval_.low.of_a == of_a_, to_own = interval_.high.of_a == of_a_;
        const double length = interval_.length_mm();
        double half =
            std::clamp(length, std::min(least_clearance_mm, options_.clearance_mm), options_.clearance_mm);
        const double low = interval_.low.t - (from_own ? std::min(half, 0.5 * interval_.low.room_mm) : 0),
                     high = interval_.high.t + (to_own ? std::min(half, 0.5 * interval_.high.room_mm) : 0);
        if (!from_own || !to_own) half = std::min(half, from_own || to_own ? high - low : 0.5 * length);
        const double first = from_own ? low : low + half, last = to_own ? high : high - half;
        std::vector<Vec3> region;
        const auto add = [&](double t, double height) {
            const Vec3 p = interval_.line.at(t) + height * across();
            if (region.empty() || p != region.back()) region.push_back(p);
        };
        if (!from_own) region.push_back(interval_.low.at);
        add(first, -half);
        if (last > first) add(last, -half);
        if (!to_own) region.push_back(interval_.high.at);
        add(last, half);
        if (last > first) add(first, half);
        return region;
    }

    // Returns the region from the line to the contour beside the interval.
    std::vector<Vec3> up_to(const NearestArc& arc) const {
        struct PlaceOnLine {
            double t;
            Vec3 at;
        };
        std::vector<PlaceOnLine> places;
        for (const std::uint32_t k : arc.points)
            places.push_back({interval_.line.along(set_.points[k]), set_.points[k]});
        for (const IntervalEndpoint& place : arc.places)
            places.push_back({interval_.line.along(place.at), place.at});
        std::sort(places.begin(), places.end(),
                  [](const PlaceOnLine& p, const PlaceOnLine& q) { return p.t > q.t; });
        std::vector<Vec3> region{interval_.low.at, interval_.high.at};
        for (const PlaceOnLine& place : places) {
            if (place.at != region.back()) region.push_back(place.at);
        }
        return region;
    }

    Vec3 across() const { return cross(set_.slices[slice_].plane.normal, interval_.line.direction); }

    const ContourSet& set_;
    const ConflictingInterval& interval_;
    const std::uint32_t slice_, other_;
    const bool inside_, of_a_;
    const ConflictingIntervalOptions& options_;
};

// Counts with how many slices each one differs about each structure.
class Contradicted {
  public:
    Contradicted(const ContourSet& set, std::span<const LineComparison> comparisons)
        : structures_(set.structures.size()), count_(set.slices.size() * structures_, 0) {
        for (const LineComparison& c : comparisons) {
            if (c.difference_mm <= least_difference_mm) continue;
            ++count_[c.a * structures_ + c.structure];
            ++count_[c.b * structures_ + c.structure];
        }
    }
    std::uint32_t by(std::uint32_t slice, std::uint32_t structure) const {
        return count_[slice * structures_ + structure];
    }

  private:
    std::size_t structures_;
    std::vector<std::uint32_t> count_;
};

class IntervalResolution {
  public:
    IntervalResolution(ContourSet& set, OriginalPositions& drawn, std::vector<LineComparison> comparisons,
                       const CompareSlices& compare, const ConflictingIntervalOptions& options,
                       RunContext& context)
        : set_(set),
          drawn_(drawn),
          comparisons_(std::move(comparisons)),
          contradicted_(set, comparisons_),
          compare_(compare),
          options_(options),
          context_(context) {}

    std::vector<ResolvedInterval> run() {
        while (resolved_.size() < most_edits && resolve_one()) {
        }
        return std::move(resolved_);
    }

  private:
    using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, double, double>;
    static Key key_of(const ConflictingInterval& interval) {
        return {interval.a, interval.b, interval.structure, interval.low.t, interval.high.t};
    }

    // Resolves the first interval that can be resolved. Returns whether there was one.
    bool resolve_one() {
        const LineVotes votes(comparisons_);
        for (std::size_t c = 0; c < comparisons_.size(); ++c) {
            if (comparisons_[c].difference_mm <= least_interval_length_mm) continue;
            for (const ConflictingInterval& interval : conflicting_intervals_of(comparisons_[c])) {
                const auto at = std::lower_bound(given_up_.begin(), given_up_.end(), key_of(interval));
                if (at != given_up_.end() && *at == key_of(interval)) continue;
                given_up_.insert(at, key_of(interval));
                if (resolve(interval, comparisons_[c], votes)) return true;
                if (tries_ > most_tries || context_.cancelled()) return false;
            }
        }
        return false;
    }

    bool resolve(const ConflictingInterval& interval, const LineComparison& comparison,
                 const LineVotes& votes) {
        const bool most_as_a = votes.most_agree(comparison, interval.a, interval.middle()),
                   most_as_b = votes.most_agree(comparison, interval.b, interval.middle());
        const std::uint32_t of_a = contradicted_.by(interval.a, interval.structure),
                            of_b = contradicted_.by(interval.b, interval.structure);
        const bool may_a = most_as_b || (!most_as_a && of_a >= of_b),
                   may_b = most_as_a || (!most_as_b && of_b >= of_a);
        std::vector<IntervalEdit> edits;
        if (may_a) IntervalEdits(set_, interval, true, options_).add_to(edits);
        if (may_b) IntervalEdits(set_, interval, false, options_).add_to(edits);
        if (edits.empty() && (most_as_a || most_as_b))
            IntervalEdits(set_, interval, most_as_b, options_).add_lone_to(edits);
        std::stable_sort(edits.begin(), edits.end(), [](const IntervalEdit& p, const IntervalEdit& q) {
            return p.farthest_mm < q.farthest_mm;
        });
        const double left = total_difference_mm(comparisons_);
        for (const IntervalEdit& edit : edits) {
            if (++tries_ > most_tries || context_.cancelled()) return false;
            const ContourSet changed = with_edited(set_, edit.slice, edit.rings);
            std::vector<LineComparison> after = compare_(changed);
            if (total_difference_mm(after) > left - least_edit_gain * interval.length_mm()) continue;
            const bool parts = edit.rings.size() != set_.slices[edit.slice].contour_count;
            carry_drawn(changed);
            set_ = changed;
            comparisons_ = std::move(after);
            resolved_.push_back({edit.slice, interval.structure, edit.other, edit.inside, parts,
                                 interval.length_mm(), edit.farthest_mm});
            return true;
        }
        return false;
    }

    // Keeps the original positions of points that stay; a new point was drawn where it is.
    void carry_drawn(const ContourSet& changed) {
        OriginalPositions now{changed.points, std::vector<bool>(changed.points.size(), false)};
        for (std::size_t s = 0; s < changed.slices.size(); ++s) {
            std::vector<std::uint32_t> old;
            for (const Contour& contour : set_.contours_of(set_.slices[s])) {
                for (std::uint32_t n = 0; n < contour.point_count; ++n)
                    old.push_back(contour.first_point + n);
            }
            std::sort(old.begin(), old.end(), [&](std::uint32_t p, std::uint32_t q) {
                return lexicographic_less(set_.points[p], set_.points[q]);
            });
            for (const Contour& contour : changed.contours_of(changed.slices[s])) {
                for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count;
                     ++k) {
                    const auto found = std::lower_bound(
                        old.begin(), old.end(), changed.points[k],
                        [&](std::uint32_t p, Vec3 q) { return lexicographic_less(set_.points[p], q); });
                    if (found == old.end() || set_.points[*found] != changed.points[k]) continue;
                    now.at[k] = drawn_.at[*found];
                    now.is_drawn[k] = drawn_.is_drawn[*found];
                }
            }
        }
        drawn_ = std::move(now);
    }

    ContourSet& set_;
    OriginalPositions& drawn_;
    std::vector<LineComparison> comparisons_;
    const Contradicted contradicted_;  // before anything was changed
    const CompareSlices& compare_;
    const ConflictingIntervalOptions& options_;
    RunContext& context_;
    std::vector<Key> given_up_;  // sorted: pieces that were tried
    std::vector<ResolvedInterval> resolved_;
    std::size_t tries_ = 0;
};

}  // namespace

std::vector<ResolvedInterval> resolve_conflicting_intervals(ContourSet& set, OriginalPositions& drawn,
                                                            std::vector<LineComparison> comparisons,
                                                            const CompareSlices& compare,
                                                            const ConflictingIntervalOptions& options,
                                                            RunContext& context) {
    assert(options.clearance_mm > 0 && options.most_mm > 0);
    return IntervalResolution(set, drawn, std::move(comparisons), compare, options, context).run();
}

}  // namespace anatomesh
