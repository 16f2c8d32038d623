// SegmentGuard: keeps free points off the contours, so that contour segments tend to be edges of the mesh.
#pragma once

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
    void add_segment(Vec3 p, Vec3 q) {
        const double half = 0.5 * length(q - p);
        midpoints_.add(0.5 * (p + q));
        squared_half_lengths_.push_back(half * half);
        longest_half_ = half > longest_half_ ? half : longest_half_;
    }

    bool any_point_within(Vec3 p, double distance) const { return points_.any_within(p, distance); }

    // Whether p lies in no segment's diametral ball.
    bool outside_balls(Vec3 p) const {
        bool free = true;
        midpoints_.for_each_within(p, longest_half_, [&](std::uint32_t segment, double squared) {
            if (squared < squared_half_lengths_[segment]) free = false;
        });
        return free;
    }
    // Whether moreover no contour point is nearer than `distance`.
    bool allows(Vec3 p, double distance) const { return !any_point_within(p, distance) && outside_balls(p); }

  private:
    PointGrid points_, midpoints_;
    std::vector<double> squared_half_lengths_;
    double longest_half_ = 0;
};

}  // namespace anatomesh
