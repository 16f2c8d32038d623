// ContourLoop: a contour that is re-routed, stretch by stretch, away from where it is drawn.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// A vertex of a contour and its place on what is drawn: the number of a segment, and the part of it that lies
// before the place.
struct LoopCorner {
    std::uint32_t vertex = 0;
    double at = 0;
};

// What comes in the place of a stretch, between places on what is drawn.
struct LoopStretch {
    double from = 0, to = 0;              // from < to; either may lie beyond the ends of the loop
    std::vector<std::uint32_t> vertices;  // with both ends
    std::vector<Vec3> places;             // of these
};

class ContourLoop {
  public:
    // `drawn`: the vertices of the contour; `places`: theirs.
    ContourLoop(std::span<const std::uint32_t> drawn, std::vector<Vec3> places);

    std::size_t size() const { return corners_.size(); }
    const LoopCorner& corner(std::size_t n) const { return corners_[n % corners_.size()]; }
    // Beside corner n (modulo the size), on the side of `step` (+1 or -1), with a place that goes on from
    // `at`, which is that of corner n.
    LoopCorner beside(std::size_t n, double at, int step) const;

    // The number of drawn segments; places go round by it.
    double length() const { return static_cast<double>(drawn_.size()); }
    std::uint32_t drawn(std::int64_t n) const { return drawn_[wrapped(n)]; }
    // What is drawn from one place to another, both included.
    std::vector<Vec3> drawn_between(double from, double to) const;

    // Puts it in. Returns whether at least three corners are left; if not, the loop is as it was.
    bool replace(const LoopStretch& stretch);

  private:
    std::size_t wrapped(std::int64_t n) const;

    std::vector<std::uint32_t> drawn_;
    std::vector<Vec3> places_;
    std::vector<LoopCorner> corners_;  // by place
};

// The point of a row of points, one after the other joined, that is nearest to p. Requires: at least one.
Vec3 nearest_on_row(std::span<const Vec3> row, Vec3 p);

// The larger of the distances of the points of either row from the other one.
double distance_of_rows(std::span<const Vec3> row, std::span<const Vec3> other);

}  // namespace anatomesh
