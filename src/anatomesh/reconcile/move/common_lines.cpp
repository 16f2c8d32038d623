#include "anatomesh/reconcile/move/common_lines.h"

#include <algorithm>
#include <cassert>
#include <vector>

namespace anatomesh {

namespace {

using Ring = std::vector<Vec3>;

// A segment of a slice that lies on a line, by its contour and the vertex that it starts at.
struct Along {
    std::uint32_t contour = 0, from = 0;
};

class ContoursOnLines {
  public:
    ContoursOnLines(ContourSet& set, const CommonLineOptions& options) : set_(set), width_(options.width_mm) {
        for (const Contour& contour : set.contours) {
            const auto points = set.points_of(contour);
            rings_.emplace_back(points.begin(), points.end());
        }
    }

    void lead(std::uint32_t a, std::uint32_t b) {
        const Vec3 across = cross(set_.slices[a].plane.normal, set_.slices[b].plane.normal);
        const double sine = length(across);
        if (!(sine > 0)) return;
        const Vec3 direction = (1 / sine) * across;
        if (along(a, b, sine).empty() || along(b, a, sine).empty()) return;
        make_one(a, b, sine);
        lead_through(ends_on(b, a, sine), direction, along(a, b, sine));
        lead_through(ends_on(a, b, sine), direction, along(b, a, sine));
    }

    // Writes the contours back to the set, and returns what was done.
    CommonLineStats finish() {
        if (stats_.led_through == 0 && stats_.moved == 0) return stats_;
        set_.points.clear();
        for (std::uint32_t c = 0; c < rings_.size(); ++c) {
            Ring& ring = rings_[c];
            std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end(), LexicographicLess{}),
                        ring.end());
            set_.contours[c].first_point = static_cast<std::uint32_t>(set_.points.size());
            set_.contours[c].point_count = static_cast<std::uint32_t>(ring.size());
            set_.points.insert(set_.points.end(), ring.begin(), ring.end());
        }
        return stats_;
    }

  private:
    // In the plane of its own slice the distance from the line is the distance from the other plane over
    // the sine.
    bool is_on(Vec3 p, std::uint32_t other, double sine) const {
        return std::abs(set_.slices[other].plane.signed_distance(p)) <= width_ * sine;
    }

    std::vector<Along> along(std::uint32_t slice, std::uint32_t other, double sine) const {
        std::vector<Along> found;
        const Slice& own = set_.slices[slice];
        for (std::uint32_t c = own.first_contour; c < own.first_contour + own.contour_count; ++c) {
            const Ring& ring = rings_[c];
            bool is_from_on = is_on(ring[0], other, sine);
            for (std::uint32_t n = 0; n < ring.size(); ++n) {
                const bool is_to_on = is_on(ring[(n + 1) % ring.size()], other, sine);
                if (is_from_on && is_to_on) found.push_back({c, n});
                is_from_on = is_to_on;
            }
        }
        return found;
    }

    // Returns the vertices of the segments on the line.
    std::vector<Vec3> ends_on(std::uint32_t slice, std::uint32_t other, double sine) const {
        std::vector<Vec3> ends;
        for (const Along& one : along(slice, other, sine)) {
            const Ring& ring = rings_[one.contour];
            ends.insert(ends.end(), {ring[one.from], ring[(one.from + 1) % ring.size()]});
        }
        return ends;
    }

    // Vertices of slice b on the line become vertices of slice a that are as near as the width.
    void make_one(std::uint32_t a, std::uint32_t b, double sine) {
        const std::vector<Vec3> first = ends_on(a, b, sine);
        for (const Along& one : along(b, a, sine)) {
            Ring& ring = rings_[one.contour];
            for (const std::size_t n : {std::size_t{one.from}, (one.from + 1) % ring.size()}) {
                const auto nearest = std::min_element(first.begin(), first.end(), [&](Vec3 p, Vec3 q) {
                    return squared_length(p - ring[n]) < squared_length(q - ring[n]);
                });
                const double distance = length(*nearest - ring[n]);
                if (distance == 0 || distance > width_ ||
                    std::find(ring.begin(), ring.end(), *nearest) != ring.end())
                    continue;
                ring[n] = *nearest;
                ++stats_.moved;
                stats_.farthest_mm = std::max(stats_.farthest_mm, distance);
            }
        }
    }

    void lead_through(std::vector<Vec3> others, Vec3 direction, const std::vector<Along>& segments) {
        const auto before = [&](Vec3 p, Vec3 q) { return dot(p, direction) < dot(q, direction); };
        std::stable_sort(others.begin(), others.end(), before);
        others.erase(std::unique(others.begin(), others.end()), others.end());
        // The last segment is taken first, so that the places of the others stay.
        for (auto one = segments.rbegin(); one != segments.rend(); ++one) {
            Ring& ring = rings_[one->contour];
            const Vec3 from = ring[one->from], to = ring[(one->from + 1) % ring.size()];
            const double low = std::min(dot(from, direction), dot(to, direction)) + width_,
                         high = std::max(dot(from, direction), dot(to, direction)) - width_;
            std::vector<Vec3> between;
            for (const Vec3& p : others) {
                const double at = dot(p, direction);
                if (at > low && at < high &&
                    (between.empty() || at > dot(between.back(), direction) + width_))
                    between.push_back(p);
            }
            if (dot(to - from, direction) < 0) std::reverse(between.begin(), between.end());
            ring.insert(ring.begin() + one->from + 1, between.begin(), between.end());
            stats_.led_through += between.size();
        }
    }

    ContourSet& set_;
    const double width_;
    std::vector<Ring> rings_;  // by contour
    CommonLineStats stats_;
};

}  // namespace

CommonLineStats lead_along_common_lines(ContourSet& set,
                                        std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs,
                                        const CommonLineOptions& options) {
    assert(options.width_mm >= 0);
    ContoursOnLines contours(set, options);
    for (const auto& [a, b] : pairs) contours.lead(a, b);
    return contours.finish();
}

}  // namespace anatomesh
