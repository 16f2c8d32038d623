#include "anatomesh/reconcile/resolve/nearest_arc.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "anatomesh/reconcile/move/contour_graph.h"

namespace anatomesh {

namespace {

// Gives a contour in coordinates along the line and across it.
class FromLine {
  public:
    FromLine(const ContourSet& set, const Slice& slice, const Line& line, const Plane& other)
        : set_(set), line_(line), other_(other) {
        across_ = {dot(other.normal, slice.plane.u), dot(other.normal, slice.plane.v)};
        sine_ = length(across_);
    }

    double along(std::uint32_t point) const { return line_.along(set_.points[point]); }
    double height(std::uint32_t point) const { return other_.signed_distance(set_.points[point]) / sine_; }
    bool is_steep(std::uint32_t from, std::uint32_t to) const {
        return std::abs(height(to) - height(from)) > steepest_along_line * std::abs(along(to) - along(from));
    }
    Vec2 away_from(double side) const { return (-side / sine_) * across_; }

    // Returns the share of the segment at which it passes t. Requires: its ends lie on either side of t.
    double share_at(double t, std::uint32_t from, std::uint32_t to) const {
        return (t - along(from)) / (along(to) - along(from));
    }
    double height_at(double share, std::uint32_t from, std::uint32_t to) const {
        return (1 - share) * height(from) + share * height(to);
    }

  private:
    const ContourSet& set_;
    const Line& line_;
    const Plane& other_;
    Vec2 across_;
    double sine_ = 1;
};

// A segment of a contour that lies beside a part of the interval, on one side of the line.
struct NearestSegment {
    const Contour* contour = nullptr;
    std::uint32_t from = 0, to = 0;
    double height_mm = std::numeric_limits<double>::infinity();
};

NearestSegment nearest_segment(const ContourSet& set, const Slice& slice, std::uint32_t structure,
                               const FromLine& seen, double low, double high) {
    NearestSegment nearest;
    for (const Contour& contour : set.contours_of(slice)) {
        if (contour.structure != structure) continue;
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            const std::uint32_t next = point_after(contour, k);
            const double first = std::min(seen.along(k), seen.along(next)),
                         last = std::max(seen.along(k), seen.along(next));
            const double begin = std::max(first, low), end = std::min(last, high);
            if (!(begin < end) || !(seen.height(k) * seen.height(next) > 0) || seen.is_steep(k, next))
                continue;
            double least = std::numeric_limits<double>::infinity();
            for (const double t : {begin, end})
                least = std::min(least, std::abs(seen.height_at(seen.share_at(t, k, next), k, next)));
            if (least < nearest.height_mm) nearest = {&contour, k, next, least};
        }
    }
    return nearest;
}

}  // namespace

NearestArc nearest_arc(const ContourSet& set, std::uint32_t own, std::uint32_t structure, const Line& line,
                       const Plane& other, double low, double high) {
    assert(low < high);
    const Slice& slice = set.slices[own];
    const FromLine seen(set, slice, line, other);
    const NearestSegment nearest = nearest_segment(set, slice, structure, seen, low, high);
    if (nearest.contour == nullptr) return {};
    const Contour& contour = *nearest.contour;
    const double way = seen.along(nearest.to) > seen.along(nearest.from) ? 1 : -1;
    const double side = seen.height(nearest.from) > 0 ? 1 : -1;
    const auto runs_on = [&](std::uint32_t from, std::uint32_t to) {
        return way * (seen.along(to) - seen.along(from)) > 0 && !seen.is_steep(from, to) &&
               side * seen.height(from) > 0 && side * seen.height(to) > 0;
    };
    const auto is_beside = [&](std::uint32_t point) {
        return seen.along(point) > low && seen.along(point) < high;
    };
    // The arc is followed back to where it begins, and on to where it ends.
    std::uint32_t first = nearest.from, last = nearest.to;
    for (std::uint32_t n = 0; n < contour.point_count && is_beside(first); ++n) {
        const std::uint32_t before = point_before(contour, first);
        if (!runs_on(before, first)) break;
        first = before;
    }
    for (std::uint32_t n = 0; n < contour.point_count && is_beside(last); ++n) {
        const std::uint32_t next = point_after(contour, last);
        if (!runs_on(last, next)) break;
        last = next;
    }
    NearestArc arc;
    arc.back = seen.away_from(side);
    for (std::uint32_t k = first;; k = point_after(contour, k)) {
        if (is_beside(k)) {
            arc.points.push_back(k);
            arc.heights_mm.push_back(std::abs(seen.height(k)));
            arc.height_mm = std::max(arc.height_mm, arc.heights_mm.back());
        }
        if (k == last) break;
        const std::uint32_t next = point_after(contour, k);
        for (const double t : {low, 0.5 * (low + high), high}) {
            const double share = seen.share_at(t, k, next);
            if (!(share > 0 && share < 1)) continue;
            const Vec3 at = set.points[k] + share * (set.points[next] - set.points[k]);
            arc.places.push_back(
                {static_cast<std::uint32_t>(&contour - set.contours.data()), k, next, at, t});
            arc.height_mm = std::max(arc.height_mm, std::abs(seen.height_at(share, k, next)));
        }
    }
    return arc;
}

}  // namespace anatomesh
