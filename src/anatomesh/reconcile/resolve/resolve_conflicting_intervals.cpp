#include "anatomesh/reconcile/resolve/resolve_conflicting_intervals.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "anatomesh/reconcile/move/movement_nodes.h"
#include "anatomesh/reconcile/resolve/facing_stretch.h"
#include "anatomesh/reconcile/resolve/line_votes.h"
#include "anatomesh/reconcile/resolve/repaint.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_changes = 200, most_tries = 1000;
constexpr double most_times = 3;  // a change may be larger than the piece, or the clearance: a spike
// Shorter ones are left: contours would get segments as short, and cells of that size.
constexpr double least_piece_mm = 0.01;
constexpr double least_gain = 0.5;           // of the piece: by so much slices have to differ less
constexpr double least_difference_mm = 0.1;  // on a line, of slices that contradict each other

// Where on a line a piece begins or ends.
struct PieceEnd {
    double t = 0;
    Vec3 at;
    bool of_a = false;   // of slice a's contour, or b's
    double room_mm = 0;  // to the next end beyond it, of either slice
};

struct Piece {
    std::uint32_t a = 0, b = 0, structure = 0;
    Line line;
    PieceEnd low, high;
    bool in_a = false;  // inside on slice a, outside on b; or the other way round
    double length_mm() const { return high.t - low.t; }
    double middle() const { return 0.5 * (low.t + high.t); }
};

std::vector<Piece> pieces_of(const LineComparison& c) {
    std::vector<PieceEnd> ends;
    for (const LineEnd& end : c.ends_a) ends.push_back({end.t, end.at, true, 0});
    for (const LineEnd& end : c.ends_b) ends.push_back({end.t, end.at, false, 0});
    std::sort(ends.begin(), ends.end(),
              [](const PieceEnd& p, const PieceEnd& q) { return p.t != q.t ? p.t < q.t : p.of_a > q.of_a; });
    std::vector<Piece> pieces;
    bool in_a = false, in_b = false;
    for (std::size_t n = 0; n + 1 < ends.size(); ++n) {
        (ends[n].of_a ? in_a : in_b) ^= true;
        if (in_a == in_b || ends[n + 1].t - ends[n].t <= least_piece_mm) continue;
        Piece piece{c.a, c.b, c.structure, c.line, ends[n], ends[n + 1], in_a};
        constexpr double infinity = std::numeric_limits<double>::infinity();
        piece.low.room_mm = n > 0 ? ends[n].t - ends[n - 1].t : infinity;
        piece.high.room_mm = n + 2 < ends.size() ? ends[n + 2].t - ends[n + 1].t : infinity;
        pieces.push_back(piece);
    }
    return pieces;
}

// A change of one slice.
struct Change {
    std::uint32_t slice = 0, other = 0;
    bool inside = false;
    double farthest_mm = std::numeric_limits<double>::infinity();
    std::vector<PaintedRing> rings;
};

// The ways in which a slice can come to have on a piece what the other one has.
class Ways {
  public:
    Ways(const ContourSet& set, const Piece& piece, bool of_a, const ConflictingIntervalOptions& options)
        : set_(set),
          piece_(piece),
          slice_(of_a ? piece.a : piece.b),
          other_(of_a ? piece.b : piece.a),
          inside_(of_a != piece.in_a),
          of_a_(of_a),
          options_(options) {}

    void add_to(std::vector<Change>& all) {
        const std::vector<std::vector<Vec3>> strip{beside_the_line()};
        const std::optional<std::vector<PaintedRing>> narrow =
            repaint(set_, {slice_, piece_.structure, inside_, strip, {}});
        if (narrow) {
            add(*narrow, all);
            add_without_cut_off(*narrow, all);
        }
        if (piece_.low.of_a == of_a_ && piece_.high.of_a == of_a_) return;
        const FacingStretch stretch = facing_stretch(set_, slice_, piece_.structure, piece_.line,
                                                     set_.slices[other_].plane, piece_.low.t, piece_.high.t);
        if (stretch.empty()) return;
        const std::vector<std::vector<Vec3>> regions{strip.front(), up_to(stretch)};
        if (regions.back().size() < 3) return;
        if (auto rings = repaint(set_, {slice_, piece_.structure, inside_, regions, stretch.places}))
            add(std::move(*rings), all);
    }

    // What lies beside the line alone, where no contour is near that could come there.
    void add_lone_to(std::vector<Change>& all) {
        const std::vector<std::vector<Vec3>> regions{beside_the_line()};
        std::optional<std::vector<PaintedRing>> rings =
            repaint(set_, {slice_, piece_.structure, inside_, regions, {}});
        const double half = 0.5 * piece_.length_mm();
        if (rings && piece_.length_mm() <= options_.most_parted_mm)
            all.push_back({slice_, other_, inside_, half, std::move(*rings)});
    }

  private:
    void add(std::vector<PaintedRing> rings, std::vector<Change>& all) const {
        if (rings.size() != set_.slices[slice_].contour_count && piece_.length_mm() > options_.most_parted_mm)
            return;
        const double farthest = farthest_change(set_, slice_, rings);
        const double most =
            std::min(options_.most_mm, most_times * std::max(piece_.length_mm(), options_.clearance_mm));
        if (farthest <= most) all.push_back({slice_, other_, inside_, farthest, std::move(rings)});
    }

    // What was cut off goes, or is filled.
    void add_without_cut_off(const std::vector<PaintedRing>& narrow, std::vector<Change>& all) const {
        const ContourSet painted = with_painted(set_, slice_, narrow);
        for (const PaintedRing& ring : narrow) {
            if (!ring.is_new || ring.structure != piece_.structure) continue;
            const std::vector<std::vector<Vec3>> region{ring.points};
            if (auto rings = repaint(painted, {slice_, piece_.structure, inside_, region, {}}))
                add(std::move(*rings), all);
        }
    }

    // A strip along the piece, that goes on a little beyond an end of the slice's own contour, and runs out
    // into an end of the other's.
    std::vector<Vec3> beside_the_line() const {
        const bool from_own = piece_.low.of_a == of_a_, to_own = piece_.high.of_a == of_a_;
        const double length = piece_.length_mm();
        double half =
            std::clamp(length, std::min(least_clearance_mm, options_.clearance_mm), options_.clearance_mm);
        const double low = piece_.low.t - (from_own ? std::min(half, 0.5 * piece_.low.room_mm) : 0),
                     high = piece_.high.t + (to_own ? std::min(half, 0.5 * piece_.high.room_mm) : 0);
        if (!from_own || !to_own) half = std::min(half, from_own || to_own ? high - low : 0.5 * length);
        const double first = from_own ? low : low + half, last = to_own ? high : high - half;
        std::vector<Vec3> region;
        const auto add = [&](double t, double height) {
            const Vec3 p = piece_.line.at(t) + height * across();
            if (region.empty() || p != region.back()) region.push_back(p);
        };
        if (!from_own) region.push_back(piece_.low.at);
        add(first, -half);
        if (last > first) add(last, -half);
        if (!to_own) region.push_back(piece_.high.at);
        add(last, half);
        if (last > first) add(first, half);
        return region;
    }

    // From the line to the contour beside the piece.
    std::vector<Vec3> up_to(const FacingStretch& stretch) const {
        struct Foot {
            double t;
            Vec3 at;
        };
        std::vector<Foot> feet;
        for (const std::uint32_t k : stretch.points)
            feet.push_back({piece_.line.along(set_.points[k]), set_.points[k]});
        for (const LineEnd& place : stretch.places) feet.push_back({piece_.line.along(place.at), place.at});
        std::sort(feet.begin(), feet.end(), [](const Foot& p, const Foot& q) { return p.t > q.t; });
        std::vector<Vec3> region{piece_.low.at, piece_.high.at};
        for (const Foot& foot : feet) {
            if (foot.at != region.back()) region.push_back(foot.at);
        }
        return region;
    }

    Vec3 across() const { return cross(set_.slices[slice_].plane.normal, piece_.line.direction); }

    const ContourSet& set_;
    const Piece& piece_;
    const std::uint32_t slice_, other_;
    const bool inside_, of_a_;
    const ConflictingIntervalOptions& options_;
};

// With how many slices each one differs about each structure.
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
    IntervalResolution(ContourSet& set, DrawnPlaces& drawn, std::vector<LineComparison> comparisons,
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
        while (resolved_.size() < most_changes && resolve_one()) {
        }
        return std::move(resolved_);
    }

  private:
    using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, double, double>;
    static Key key_of(const Piece& piece) {
        return {piece.a, piece.b, piece.structure, piece.low.t, piece.high.t};
    }

    // The first piece that can be resolved.
    bool resolve_one() {
        const LineVotes votes(comparisons_);
        for (std::size_t c = 0; c < comparisons_.size(); ++c) {
            if (comparisons_[c].difference_mm <= least_piece_mm) continue;
            for (const Piece& piece : pieces_of(comparisons_[c])) {
                const auto at = std::lower_bound(given_up_.begin(), given_up_.end(), key_of(piece));
                if (at != given_up_.end() && *at == key_of(piece)) continue;
                given_up_.insert(at, key_of(piece));
                if (resolve(piece, comparisons_[c], votes)) return true;
                if (tries_ > most_tries || context_.cancelled()) return false;
            }
        }
        return false;
    }

    bool resolve(const Piece& piece, const LineComparison& comparison, const LineVotes& votes) {
        const bool most_as_a = votes.most_agree(comparison, piece.a, piece.middle()),
                   most_as_b = votes.most_agree(comparison, piece.b, piece.middle());
        const std::uint32_t of_a = contradicted_.by(piece.a, piece.structure),
                            of_b = contradicted_.by(piece.b, piece.structure);
        const bool may_a = most_as_b || (!most_as_a && of_a >= of_b),
                   may_b = most_as_a || (!most_as_b && of_b >= of_a);
        std::vector<Change> changes;
        if (may_a) Ways(set_, piece, true, options_).add_to(changes);
        if (may_b) Ways(set_, piece, false, options_).add_to(changes);
        if (changes.empty() && (most_as_a || most_as_b))
            Ways(set_, piece, most_as_b, options_).add_lone_to(changes);
        std::stable_sort(changes.begin(), changes.end(),
                         [](const Change& p, const Change& q) { return p.farthest_mm < q.farthest_mm; });
        const double left = total_difference_mm(comparisons_);
        for (const Change& change : changes) {
            if (++tries_ > most_tries || context_.cancelled()) return false;
            const ContourSet changed = with_painted(set_, change.slice, change.rings);
            std::vector<LineComparison> after = compare_(changed);
            if (total_difference_mm(after) > left - least_gain * piece.length_mm()) continue;
            const bool parts = change.rings.size() != set_.slices[change.slice].contour_count;
            carry_drawn(changed);
            set_ = changed;
            comparisons_ = std::move(after);
            resolved_.push_back({change.slice, piece.structure, change.other, change.inside, parts,
                                 piece.length_mm(), change.farthest_mm});
            return true;
        }
        return false;
    }

    // Points that were there were drawn where they were.
    void carry_drawn(const ContourSet& changed) {
        DrawnPlaces now{changed.points, std::vector<bool>(changed.points.size(), false)};
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
    DrawnPlaces& drawn_;
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

std::vector<ResolvedInterval> resolve_conflicting_intervals(ContourSet& set, DrawnPlaces& drawn,
                                                            std::vector<LineComparison> comparisons,
                                                            const CompareSlices& compare,
                                                            const ConflictingIntervalOptions& options,
                                                            RunContext& context) {
    assert(options.clearance_mm > 0 && options.most_mm > 0);
    return IntervalResolution(set, drawn, std::move(comparisons), compare, options, context).run();
}

}  // namespace anatomesh
