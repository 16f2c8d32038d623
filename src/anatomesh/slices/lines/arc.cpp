#include "anatomesh/slices/lines/arc.h"

#include <algorithm>
#include <cmath>

namespace anatomesh {

namespace {

// Points from `start` on until `stop`, if all lie on one side of the plane.
Arc arc_from(const ContourSet& set, const Contour& contour, std::uint32_t start, std::uint32_t stop,
             const Plane& own, const Plane& other) {
    const Vec2 across{dot(other.normal, own.u), dot(other.normal, own.v)};
    const double sine = length(across);
    Arc arc;
    double side = 0;
    for (std::uint32_t k = start; k != stop; k = point_after(contour, k)) {
        const double height = other.signed_distance(set.points[k]) / sine;
        if (side == 0 && std::abs(height) > line_in_plane_mm) side = height > 0 ? 1 : -1;
        if (side * height < -line_in_plane_mm || arc.points.size() == contour.point_count) return {};
        arc.points.push_back(k);
        arc.heights_mm.push_back(std::abs(height));
        arc.height_mm = std::max(arc.height_mm, std::abs(height));
    }
    if (side == 0) return {};
    arc.back = (-side / sine) * across;
    return arc;
}

}  // namespace

Arc arc_between(const ContourSet& set, const IntervalEndpoint& p, const IntervalEndpoint& q, const Plane& own,
                const Plane& other) {
    if (p.contour != q.contour) return {};
    const Contour& contour = set.contours[p.contour];
    const auto start_after = [&](const IntervalEndpoint& end) {
        return end.from == end.to ? point_after(contour, end.to) : end.to;
    };
    const auto stop_at = [](const IntervalEndpoint& end) { return end.to; };
    Arc one = arc_from(set, contour, start_after(p), stop_at(q), own, other);
    Arc two = arc_from(set, contour, start_after(q), stop_at(p), own, other);
    if (one.points.empty()) return two;
    if (two.points.empty()) return one;
    return two.height_mm < one.height_mm ? two : one;
}

}  // namespace anatomesh
