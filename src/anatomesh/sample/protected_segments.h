// ProtectedSegments: keeps free points off the contours, so that contour segments tend to be edges of the
// mesh.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/geom/point_grid.h"

namespace anatomesh {

// Holds contour points and the subsegments that contour segments were split into. A segment whose diametral
// ball (the smallest ball round it) holds no vertex is an edge of the Delaunay tetrahedralization (Shewchuk,
// Comput. Geom. 22, 2002).
class ProtectedSegments {
  public:
    // `size` is the edge length about which queries are made, mm. `lens_slope`: see ball_at(). >= 0
    ProtectedSegments(double size, std::size_t expected_points, double lens_slope = 0)
        : points_(0.5 * size, expected_points), lens_slope_(lens_slope) {
        levels_.push_back({PointGrid(size, expected_points), {}, size, 0});
    }

    void add_point(Vec3 p) { points_.add(p); }
    // Returns the number of the segment's ball.
    std::uint32_t add_segment(Vec3 p, Vec3 q) {
        const Vec3 half = 0.5 * (q - p);
        const auto ball = static_cast<std::uint32_t>(squared_half_lengths_.size());
        halves_.push_back(half);
        squared_half_lengths_.push_back(squared_length(half));
        middles_.push_back(0.5 * (p + q));
        Level& level = level_of(length(half));
        level.middles.add(middles_.back());
        level.balls.push_back(ball);
        level.longest_half = std::max(level.longest_half, length(half));
        return ball;
    }
    // For a segment that was split: its halves are added by themselves.
    void drop_ball(std::uint32_t ball) { squared_half_lengths_[ball] = -1; }

    bool any_point_within(Vec3 p, double distance) const { return points_.any_within(p, distance); }

    // The same, but for points on the shell of p about `apex`.
    bool any_point_within(Vec3 p, double distance, Vec3 apex) const {
        return any_within(points_, p, distance, apex);
    }
    static bool any_within(const PointGrid& points, Vec3 p, double distance, Vec3 apex) {
        bool found = false;
        points.for_each_within(p, distance, [&](std::uint32_t n, double) {
            found = found || !is_on_shell(points.point(n), p, apex);
        });
        return found;
    }

    // Subsegments that shells keep apart meet at no smaller angle. [radians; 0 to 1; M 2026-11 skin of a head, 36 and 60 planes]
    static constexpr double least_angle = 0.05;

    // Whether q is as far from `apex` as p is, and at no angle from it below three degrees: there,
    // subsegments that meet at the apex are split without being in each other's way.
    static bool is_on_shell(Vec3 q, Vec3 p, Vec3 apex) {
        // Distances from the apex that differ by less are the same.
        // [radii of the shell; 0 to 1e-3; D rounding of doubles]
        constexpr double as_far = 1e-6;
        const double shell = length(p - apex);
        return std::abs(length(q - apex) - shell) <= as_far * shell && length(q - p) >= least_angle * shell;
    }

    // The contour point in the diametral ball of pq that is nearest to its middle, but for p and q.
    std::optional<Vec3> point_in_ball_of(Vec3 p, Vec3 q) const {
        std::optional<Vec3> found;
        double nearest = HUGE_VAL;
        points_.for_each_within(0.5 * (p + q), 0.5 * length(q - p), [&](std::uint32_t n, double squared) {
            const Vec3 point = points_.point(n);
            if (squared >= nearest || point == p || point == q) return;
            nearest = squared;
            found = point;
        });
        return found;
    }

    // It stands for no ball. [index that no ball has; 0xFFFFFFFF; D]
    static constexpr std::uint32_t no_ball = 0xFFFFFFFFu;

    // The diametral ball that p lies in, within `share` of its radius from its middle, or so near to the
    // segment that it sees this under an angle close to 180 degrees: only subsegments as short as it is near
    // would keep clear of such a point. Of several that of the longest segment, then the first. `share`: [0,
    // 1]; 0 finds none, 1 whole balls. The tangent of what that angle may lack of 180 degrees is the lens
    // slope times the share.
    std::uint32_t ball_at(Vec3 p, double share = 1) const {
        std::uint32_t found = no_ball;
        const double reach = lens_slope_ > 0 && share > 0 ? 1 : share;
        for (const Level& level : levels_) {
            if (level.balls.empty()) continue;
            level.middles.for_each_within(
                p, reach * level.longest_half, [&](std::uint32_t n, double squared) {
                    const std::uint32_t ball = level.balls[n];
                    if (squared >= share * share * squared_half_lengths_[ball] &&
                        !in_lens(p, ball, squared, lens_slope_ * share))
                        return;
                    const bool better =
                        found == no_ball || squared_half_lengths_[ball] > squared_half_lengths_[found] ||
                        (squared_half_lengths_[ball] == squared_half_lengths_[found] && ball < found);
                    if (better) found = ball;
                });
        }
        return found;
    }
    double ball_radius(std::uint32_t ball) const { return std::sqrt(squared_half_lengths_[ball]); }
    bool outside_balls(Vec3 p) const { return ball_at(p) == no_ball; }

    // Whether moreover no contour point is nearer than `distance`.
    bool allows(Vec3 p, double distance) const { return !any_point_within(p, distance) && outside_balls(p); }

  private:
    // The balls whose radii are at most `most_half`, and above that of the level before. A grid as coarse as the
    // largest of them answers at 27 cells, however long the segments of other levels are.
    struct Level {
        PointGrid middles;
        std::vector<std::uint32_t> balls;  // of each point of `middles`
        double most_half = 0, longest_half = 0;
    };
    Level& level_of(double half) {
        while (levels_.back().most_half < half) {
            const double most_half = 2 * levels_.back().most_half;
            levels_.push_back({PointGrid(most_half, 0), {}, most_half, 0});
        }
        std::size_t n = 0;
        while (levels_[n].most_half < half) ++n;
        return levels_[n];
    }

    // The diametral lens (Shewchuk, Comput. Geom. 22, 2002): the tangent of what the angle under which p sees
    // the segment lacks of 180 degrees is 2 h d / (h^2 - m^2), with half the length h, p at m from its middle
    // and d from its line.
    bool in_lens(Vec3 p, std::uint32_t ball, double squared_to_middle, double slope) const {
        const double inside = squared_half_lengths_[ball] - squared_to_middle;
        if (inside <= 0) return false;
        const double bound = slope * inside;
        return 4 * squared_length(cross(halves_[ball], p - middles_[ball])) < bound * bound;
    }

    PointGrid points_;
    std::vector<Level> levels_;  // the first has all segments that are not long
    std::vector<Vec3> halves_, middles_;
    std::vector<double> squared_half_lengths_;
    double lens_slope_ = 0;
};

}  // namespace anatomesh
