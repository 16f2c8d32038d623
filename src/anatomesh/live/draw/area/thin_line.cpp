#include "anatomesh/live/draw/area/thin_line.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include "anatomesh/contour/simplify/chains.h"

namespace anatomesh {

std::vector<Vec2> without_repeats(std::span<const Vec2> line) {
    std::vector<Vec2> kept(line.begin(), line.end());
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    return kept;
}

std::vector<Vec2> thin_line(std::span<const Vec2> line, double tolerance_mm) {
    ChainNetwork network;
    network.points = without_repeats(line);
    if (network.points.size() < 3) return network.points;
    network.chain_points.resize(network.points.size());
    std::iota(network.chain_points.begin(), network.chain_points.end(), 0u);
    network.close_chain(true);
    const ThinResult thin = thin_chains(network, {tolerance_mm, 0, 0});
    std::vector<Vec2> kept;
    for (std::size_t i = 0; i < network.points.size(); ++i) {
        if (thin.kept[i]) kept.push_back(network.points[i]);
    }
    return kept;
}

namespace {

// The directions in which a ray from one point passes within a tolerance of others.
class PassingCone {
  public:
    explicit PassingCone(double tolerance) : tolerance_(tolerance) {}

    bool has(Vec2 d) const { return !is_bounded_ || (cross(right_, d) >= 0 && cross(d, left_) >= 0); }

    // Narrows the cone to pass the point at d. Returns whether a direction is left.
    bool narrow(Vec2 d) {
        const double square = squared_length(d);
        if (square <= tolerance_ * tolerance_) return true;
        const double along = std::sqrt(square - tolerance_ * tolerance_);
        const Vec2 left{along * d.x - tolerance_ * d.y, tolerance_ * d.x + along * d.y};
        const Vec2 right{along * d.x + tolerance_ * d.y, along * d.y - tolerance_ * d.x};
        if (!is_bounded_) {
            left_ = left, right_ = right;
            is_bounded_ = true;
            return true;
        }
        if (cross(right_, left) < 0 || cross(right, left_) < 0) return false;
        if (cross(right_, right) > 0) right_ = right;
        if (cross(left, left_) > 0) left_ = left;
        return true;
    }

  private:
    double tolerance_;
    Vec2 right_, left_;
    bool is_bounded_ = false;
};

// The farthest point of the path to which a segment from point i passes near all points between. None of them is farther
// from i than the end, so all lie beside the segment and not beyond it.
std::size_t end_of_segment(std::span<const Vec2> path, std::size_t i, double tolerance) {
    PassingCone cone(tolerance);
    double reach = 0;
    std::size_t end = i + 1;
    for (std::size_t j = i + 1; j < path.size(); ++j) {
        const Vec2 d = path[j] - path[i];
        const double distance = length(d);
        if (distance >= reach && cone.has(d)) end = j;
        if (distance < reach - tolerance || !cone.narrow(d)) break;
        reach = std::max(reach, distance);
    }
    return end;
}

}  // namespace

std::vector<Vec2> thin_path(std::span<const Vec2> path, double tolerance_mm) {
    std::vector<Vec2> kept{path[0]};
    for (std::size_t i = 0; i + 1 < path.size();) {
        i = end_of_segment(path, i, tolerance_mm);
        if (path[i] != kept.back()) kept.push_back(path[i]);
    }
    return kept;
}

std::vector<std::vector<Vec2>> thin_polygons(std::span<const std::vector<Vec2>> polygons,
                                             double tolerance_mm) {
    ChainNetwork network;
    for (const std::vector<Vec2>& polygon : polygons) {
        const auto first = static_cast<std::uint32_t>(network.points.size());
        network.points.insert(network.points.end(), polygon.begin(), polygon.end());
        for (auto p = first; p < network.points.size(); ++p) network.chain_points.push_back(p);
        network.chain_points.push_back(first);
        network.close_chain(false);
    }
    const ThinResult thin = thin_chains(network, {tolerance_mm, 0, 0});
    std::vector<std::vector<Vec2>> kept;
    std::size_t next = 0;
    for (const std::vector<Vec2>& polygon : polygons) {
        std::vector<Vec2>& thinned = kept.emplace_back();
        for (const Vec2 p : polygon) {
            if (thin.kept[next++]) thinned.push_back(p);
        }
    }
    return kept;
}

}  // namespace anatomesh
