// SegmentGuard: keeps free points off the contours, so that contour segments tend to be edges of the mesh.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "anatomesh/geom/point_grid.h"

namespace anatomesh {

// Holds contour points and the pieces that contour segments were split into. A segment whose diametral ball (the
// smallest ball round it) holds no vertex is an edge of the Delaunay tetrahedralization (Shewchuk, Comput. Geom. 22, 2002).
class SegmentGuard {
  public:
    // `size` is the edge length about which queries are made, mm.
    SegmentGuard(double size, std::size_t expected_points)
        : points_(0.5 * size, expected_points), midpoints_(size, expected_points) {}

    void add_point(Vec3 p) { points_.add(p); }
    // Returns the number of the segment's ball.
    std::uint32_t add_segment(Vec3 p, Vec3 q) {
        const double half = 0.5 * length(q - p);
        midpoints_.add(0.5 * (p + q));
        squared_half_lengths_.push_back(half * half);
        longest_half_ = half > longest_half_ ? half : longest_half_;
        return static_cast<std::uint32_t>(squared_half_lengths_.size() - 1);
    }
    // For a segment that was split: its halves are added by themselves.
    void drop_ball(std::uint32_t ball) { squared_half_lengths_[ball] = -1; }

    bool any_point_within(Vec3 p, double distance) const { return points_.any_within(p, distance); }

    static constexpr std::uint32_t no_ball = 0xFFFFFFFFu;

    // The diametral ball that p lies in, within `share` of its radius from its middle; of several that of the longest
    // segment, then the first.
    std::uint32_t ball_at(Vec3 p, double share = 1) const {
        std::uint32_t found = no_ball;
        midpoints_.for_each_within(p, share * longest_half_, [&](std::uint32_t ball, double squared) {
            if (squared >= share * share * squared_half_lengths_[ball]) return;
            const bool better = found == no_ball || squared_half_lengths_[ball] > squared_half_lengths_[found] ||
                                (squared_half_lengths_[ball] == squared_half_lengths_[found] && ball < found);
            if (better) found = ball;
        });
        return found;
    }
    double ball_radius(std::uint32_t ball) const { return std::sqrt(squared_half_lengths_[ball]); }
    bool outside_balls(Vec3 p) const { return ball_at(p) == no_ball; }

    // Whether moreover no contour point is nearer than `distance`.
    bool allows(Vec3 p, double distance) const { return !any_point_within(p, distance) && outside_balls(p); }

  private:
    PointGrid points_, midpoints_;
    std::vector<double> squared_half_lengths_;
    double longest_half_ = 0;
};

}  // namespace anatomesh
