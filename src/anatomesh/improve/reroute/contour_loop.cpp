#include "anatomesh/improve/reroute/contour_loop.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace anatomesh {

ContourLoop::ContourLoop(std::span<const std::uint32_t> drawn, std::vector<Vec3> places)
    : drawn_(drawn.begin(), drawn.end()), places_(std::move(places)) {
    assert(places_.size() == drawn_.size());
    for (std::size_t n = 0; n < drawn_.size(); ++n) corners_.push_back({drawn_[n], static_cast<double>(n)});
}

std::size_t ContourLoop::wrapped(std::int64_t n) const {
    const auto count = static_cast<std::int64_t>(drawn_.size());
    return static_cast<std::size_t>((n % count + count) % count);
}

LoopCorner ContourLoop::beside(std::size_t n, double at, int step) const {
    LoopCorner next = step > 0 ? corner(n + 1) : corner(n + corners_.size() - 1);
    while (step > 0 && next.at <= at) next.at += length();
    while (step < 0 && next.at >= at) next.at -= length();
    return next;
}

std::vector<Vec3> ContourLoop::drawn_between(double from, double to) const {
    const auto place = [&](double at) {
        const double first = std::floor(at);
        const auto n = static_cast<std::int64_t>(first);
        const Vec3 a = places_[wrapped(n)], b = places_[wrapped(n + 1)];
        return a + (at - first) * (b - a);
    };
    std::vector<Vec3> row{place(from)};
    for (auto n = static_cast<std::int64_t>(std::floor(from)) + 1; static_cast<double>(n) < to; ++n)
        row.push_back(places_[wrapped(n)]);
    row.push_back(place(to));
    return row;
}

bool ContourLoop::replace(const LoopStretch& stretch) {
    const std::vector<Vec3>& places = stretch.places;
    assert(places.size() == stretch.vertices.size());
    std::vector<double> so_far{0};
    for (std::size_t n = 1; n < places.size(); ++n)
        so_far.push_back(so_far.back() + anatomesh::length(places[n] - places[n - 1]));
    std::vector<LoopCorner> corners;
    for (std::size_t n = 0; n < places.size(); ++n) {
        const double part = so_far.back() > 0 ? so_far[n] / so_far.back() : 0;
        corners.push_back({stretch.vertices[n], stretch.from + part * (stretch.to - stretch.from)});
    }
    corners.back().at = stretch.to;
    // Those that stay, from its end on. Places of its ends are rounded.
    for (LoopCorner corner : corners_) {
        if (corner.vertex == stretch.vertices.front() || corner.vertex == stretch.vertices.back()) continue;
        while (corner.at <= stretch.to) corner.at += length();
        while (corner.at - length() > stretch.to) corner.at -= length();
        if (corner.at < stretch.from + length()) corners.push_back(corner);
    }
    if (corners.size() < 3) return false;
    // What lies a rounding before the start comes to lie on it.
    for (LoopCorner& corner : corners) {
        while (corner.at < 0) corner.at += length();
        while (corner.at >= length()) corner.at -= length();
    }
    // Places may be equal: their order stays.
    std::stable_sort(corners.begin(), corners.end(),
                     [](const LoopCorner& a, const LoopCorner& b) { return a.at < b.at; });
    corners_ = std::move(corners);
    return true;
}

Vec3 nearest_on_row(std::span<const Vec3> row, Vec3 p) {
    Vec3 nearest = row.front();
    for (std::size_t n = 1; n < row.size(); ++n) {
        const Vec3 a = row[n - 1], way = row[n] - a;
        const double whole = squared_length(way);
        const Vec3 q = whole > 0 ? a + std::clamp(dot(p - a, way) / whole, 0.0, 1.0) * way : a;
        if (squared_length(p - q) < squared_length(p - nearest)) nearest = q;
    }
    return nearest;
}

double distance_of_rows(std::span<const Vec3> row, std::span<const Vec3> other) {
    double most = 0;
    for (const Vec3 p : row) most = std::max(most, length(p - nearest_on_row(other, p)));
    for (const Vec3 p : other) most = std::max(most, length(p - nearest_on_row(row, p)));
    return most;
}

}  // namespace anatomesh
