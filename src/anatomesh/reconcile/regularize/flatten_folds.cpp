#include "anatomesh/reconcile/regularize/flatten_folds.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/reconcile/move/reindex_points.h"

namespace anatomesh {

namespace {

// A stretch is narrow if its ends are nearer to each other than this share of its length.
// [1; 0 to 1; M 2026-11 fetal brain]
constexpr double narrow_gap = 0.25;
// It also bounds less than this share of its length's square, of which a circle has 0.08.
// [1; 0 to 0.08; M 2026-11 fetal brain]
constexpr double narrow_area = 0.045;
// What was nearly so when drawn belongs to the drawing: this is the share of its length.
// [1; narrow_gap to 1; M 2026-11 fetal brain]
constexpr double drawn_gap = 0.35;
// This is the share of its length's square. [1; narrow_area to 0.08; M 2026-11 fetal brain]
constexpr double drawn_area = 0.06;
// A corner that is sharper than this may be a spike. [degrees; 0 to 180; M 2026-11 fetal brain]
constexpr double sharp_degrees = 75;
// It is one if its point was drawn blunter than this. [degrees; sharp_degrees to 180; M 2026-11 fetal brain]
constexpr double blunt_degrees = 100;
// A sharper corner bounds next to nothing and is cut off wherever it is.
// [degrees; 0 to sharp_degrees; M 2026-11 fetal brain]
constexpr double needle_degrees = 15;
// The movement made at least this share of the height of a spike. [1; 0 to 1; M 2026-11 fetal brain]
constexpr double pulled_share = 0.5;
// A lower spike is a kink, whose height says nothing. [mm; >= 0; M 2026-11 fetal brain]
constexpr double lowest_mm = 0.1;
// Where no point of a contour moved further, nothing was folded. [mm; >= 0; M 2026-11 fetal brain]
constexpr double least_move_mm = 0.5;

struct RingPoint {
    Vec3 at;
    Vec2 here, drawn;  // in the slice's plane
    bool stays = false, was_drawn = false;
};
using Ring = std::vector<RingPoint>;

// Holds lengths and areas of the stretches of a ring, as sums along it, twice round.
class Stretches {
  public:
    Stretches(const Ring& ring, bool drawn) : ring_(ring), drawn_(drawn) {
        length_.assign(1, 0);
        area_.assign(1, 0);
        for (std::size_t k = 0; k + 1 < 2 * ring.size(); ++k) {
            length_.push_back(length_.back() + anatomesh::length(at(k + 1) - at(k)));
            area_.push_back(area_.back() + 0.5 * cross(at(k), at(k + 1)));
        }
    }
    double length(std::size_t i, std::size_t j) const { return length_[j] - length_[i]; }
    bool narrow(std::size_t i, std::size_t j, double gap, double share) const {
        const double along = length(i, j);
        if (anatomesh::length(at(j) - at(i)) > gap * along) return false;
        const double area = std::abs(area_[j] - area_[i] + 0.5 * cross(at(j), at(i)));
        return area <= share * along * along;
    }

  private:
    Vec2 at(std::size_t k) const {
        const RingPoint& point = ring_[k % ring_.size()];
        return drawn_ ? point.drawn : point.here;
    }
    const Ring& ring_;
    const bool drawn_;
    std::vector<double> length_, area_;
};

struct Fold {
    std::size_t first = 0,
                last = 0;  // of the points that stay at its ends; last may be beyond the ring's end
};

std::optional<Fold> longest_fold(const Ring& ring, double longest) {
    const Stretches now(ring, false), drawn(ring, true);
    std::optional<Fold> found;
    double length = 0;
    const double most = std::min(longest, 0.5 * now.length(0, ring.size()));
    for (std::size_t i = 0; i < ring.size(); ++i) {
        for (std::size_t j = i + 2; j < i + ring.size() - 1 && now.length(i, j) <= most; ++j) {
            if (ring[(j - 1) % ring.size()].stays) break;
            if (now.length(i, j) <= length || !now.narrow(i, j, narrow_gap, narrow_area) ||
                drawn.narrow(i, j, drawn_gap, drawn_area))
                continue;
            found = Fold{i, j};
            length = now.length(i, j);
        }
    }
    return found;
}

double corner_degrees(Vec2 before, Vec2 at, Vec2 after) {
    const Vec2 u = before - at, v = after - at;
    return std::abs(std::atan2(cross(u, v), dot(u, v))) * 180 / std::numbers::pi;
}

// Returns the drawn points on both sides of one that was drawn.
std::array<const RingPoint*, 2> drawn_beside(const Ring& ring, std::size_t k) {
    const std::size_t n = ring.size();
    std::size_t before = (k + n - 1) % n, after = (k + 1) % n;
    while (!ring[before].was_drawn) before = (before + n - 1) % n;
    while (!ring[after].was_drawn) after = (after + 1) % n;
    return {&ring[before], &ring[after]};
}

// Returns the signed height of q over the way from p to r.
double height(Vec2 p, Vec2 q, Vec2 r) {
    const double way = length(r - p);
    return way > 0 ? cross(r - p, q - p) / way : length(q - p);
}

// Returns whether the movement made a sharp corner of a blunt one.
bool was_pulled_out(const Ring& ring, std::size_t k) {
    const RingPoint& point = ring[k];
    if (!point.was_drawn) return true;
    const auto [before, after] = drawn_beside(ring, k);
    const std::size_t n = ring.size();
    if (std::abs(height(ring[(k + n - 1) % n].here, point.here, ring[(k + 1) % n].here)) <= lowest_mm)
        return corner_degrees(before->drawn, point.drawn, after->drawn) >= blunt_degrees;
    const double now = height(before->here, point.here, after->here);
    const double drawn = height(before->drawn, point.drawn, after->drawn);
    return corner_degrees(before->drawn, point.drawn, after->drawn) >= blunt_degrees &&
           std::abs(now - drawn) >= pulled_share * std::abs(now);
}

// Returns the sharpest corner below an angle that was none when drawn, if its point belongs to the contour
// alone.
std::optional<Fold> sharpest_spike(const Ring& ring, double sharp) {
    std::optional<Fold> found;
    const std::size_t n = ring.size();
    double least = sharp;
    for (std::size_t i = 0; i < n; ++i) {
        const RingPoint &a = ring[i], &b = ring[(i + 1) % n], &c = ring[(i + 2) % n];
        // A point between two common points may be all that is left of an interval on a common line.
        if (b.stays || (a.stays && c.stays)) continue;
        const double now = corner_degrees(a.here, b.here, c.here);
        if (now >= least || !was_pulled_out(ring, (i + 1) % n)) continue;
        found = Fold{i, i + 2};
        least = now;
    }
    return found;
}

// Takes the points between the fold's ends out of the ring.
void take_out(Ring& ring, const Fold& fold, FoldStats& stats) {
    const Vec2 a = ring[fold.first].here, way = ring[fold.last % ring.size()].here - a;
    const double squared = squared_length(way);
    std::vector<bool> out(ring.size(), false);
    for (std::size_t k = fold.first + 1; k < fold.last; ++k) {
        const Vec2 from = ring[k % ring.size()].here - a;
        const double t = squared > 0 ? std::clamp(dot(from, way) / squared, 0.0, 1.0) : 0;
        stats.highest_mm = std::max(stats.highest_mm, length(from - t * way));
        out[k % ring.size()] = true;
        ++stats.vertices;
    }
    Ring kept;
    for (std::size_t k = 0; k < ring.size(); ++k) {
        if (!out[k]) kept.push_back(ring[k]);
    }
    ring = std::move(kept);
}

class FoldRemoval {
  public:
    FoldRemoval(ContourSet& set, std::vector<MovedPoint> moved, const FoldOptions& options)
        : set_(set), moved_(std::move(moved)), options_(options) {
        std::sort(moved_.begin(), moved_.end(),
                  [](const MovedPoint& p, const MovedPoint& q) { return lexicographic_less(p.at, q.at); });
        for (std::uint32_t c = 0; c < set.contours.size(); ++c) {
            for (const Vec3& point : set.points_of(set.contours[c])) owners_.push_back({point, c});
        }
        std::sort(owners_.begin(), owners_.end(), [](const Owner& p, const Owner& q) {
            return p.at != q.at ? lexicographic_less(p.at, q.at) : p.contour < q.contour;
        });
    }

    FoldStats run() {
        std::vector<std::vector<Vec3>> fresh(set_.contours.size());
        for (const Slice& slice : set_.slices) flatten(slice, fresh);
        reindex_points(set_, fresh);
        return stats_;
    }

  private:
    struct Owner {
        Vec3 at;
        std::uint32_t contour;
    };

    bool is_shared(Vec3 point) const {
        const auto range =
            std::equal_range(owners_.begin(), owners_.end(), Owner{point, 0},
                             [](const Owner& p, const Owner& q) { return lexicographic_less(p.at, q.at); });
        return range.first->contour != (range.second - 1)->contour;
    }

    // A point that nobody drew counts as moved like the one before it.
    Ring ring_of(const Contour& contour, const Plane& plane, double& furthest) const {
        const auto points = set_.points_of(contour);
        std::optional<Vec3> move;
        Ring ring;
        for (std::size_t k = 0; k < 2 * points.size(); ++k) {
            const Vec3 point = points[k % points.size()];
            const auto found =
                std::lower_bound(moved_.begin(), moved_.end(), point,
                                 [](const MovedPoint& p, Vec3 q) { return lexicographic_less(p.at, q); });
            const bool was_drawn = found != moved_.end() && found->at == point;
            if (was_drawn) move = point - found->drawn;
            if (k < points.size())
                continue;  // the first time round finds the move that the second begins with
            furthest = std::max(furthest, length(move.value_or(Vec3{})));
            ring.push_back({point, plane.to_plane(point), plane.to_plane(point - move.value_or(Vec3{})),
                            is_shared(point), was_drawn});
        }
        return ring;
    }

    // Gives the slice's contours without their folds, or as they are where the slice would not be sound.
    void flatten(const Slice& slice, std::vector<std::vector<Vec3>>& fresh) {
        FoldStats stats = stats_;
        const auto number = static_cast<std::size_t>(&slice - set_.slices.data());
        const bool keeps_spikes = !options_.keeps_spikes.empty() && options_.keeps_spikes[number];
        std::vector<PlaneRing> rings;
        for (std::uint32_t c = slice.first_contour; c < slice.first_contour + slice.contour_count; ++c) {
            double furthest = 0;
            Ring ring = ring_of(set_.contours[c], slice.plane, furthest);
            while (furthest >= least_move_mm && ring.size() > 4) {
                const std::optional<Fold> fold = longest_fold(ring, options_.longest_mm);
                const std::optional<Fold> spike =
                    fold ? std::nullopt : sharpest_spike(ring, keeps_spikes ? needle_degrees : sharp_degrees);
                if (!fold && !spike) break;
                ++(fold ? stats.folds : stats.spikes);
                take_out(ring, fold ? *fold : *spike, stats);
            }
            PlaneRing flat{set_.contours[c].structure, {}};
            for (const RingPoint& point : ring) {
                flat.at.push_back(point.here);
                fresh[c].push_back(point.at);
            }
            rings.push_back(std::move(flat));
        }
        if (stats.vertices == stats_.vertices) return;
        if (slice_faults(rings, set_.exclusive).empty()) {
            stats_ = stats;
            return;
        }
        for (std::uint32_t c = slice.first_contour; c < slice.first_contour + slice.contour_count; ++c) {
            const auto points = set_.points_of(set_.contours[c]);
            fresh[c].assign(points.begin(), points.end());
        }
    }

    ContourSet& set_;
    std::vector<MovedPoint> moved_;  // sorted by their place
    const FoldOptions& options_;
    std::vector<Owner> owners_;  // of every point, sorted
    FoldStats stats_;
};

}  // namespace

FoldStats flatten_folds(ContourSet& set, std::vector<MovedPoint> moved, const FoldOptions& options) {
    assert(options.longest_mm > 0);
    return FoldRemoval(set, std::move(moved), options).run();
}

}  // namespace anatomesh
