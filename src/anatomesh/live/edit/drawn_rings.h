// DrawnRings: what a person drew of one structure on one plane, exactly as it was drawn.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// What a ring was made with. Of a polygon and a spline the control points are kept beside the ring.
enum class RingTool : std::uint8_t { stroke, polygon, spline };

// The vertices are points[first_point, first_point + point_count); the first is not repeated. So are the control points.
struct DrawnRing {
    RingTool tool = RingTool::stroke;
    std::uint32_t first_point = 0, point_count = 0;
    std::uint32_t first_control = 0, control_count = 0;  // of control_points; count 0: none
};

// Closed polygons; their even-odd interior is the region. Points are in mm, in space. Start and direction of a ring are as
// drawn. Guarantees by those that make it: points and control points of the rings follow each other in the order of the
// rings, without a gap.
struct DrawnRings {
    std::vector<DrawnRing> rings;
    std::vector<Vec3> points, control_points;

    std::span<const Vec3> points_of(const DrawnRing& ring) const {
        return {points.data() + ring.first_point, ring.point_count};
    }
    std::span<const Vec3> control_points_of(const DrawnRing& ring) const {
        return {control_points.data() + ring.first_control, ring.control_count};
    }
    // O(points)
    void add(std::span<const Vec3> ring, RingTool tool = RingTool::stroke,
             std::span<const Vec3> control = {}) {
        rings.push_back(
            {tool, static_cast<std::uint32_t>(points.size()), static_cast<std::uint32_t>(ring.size()),
             static_cast<std::uint32_t>(control_points.size()), static_cast<std::uint32_t>(control.size())});
        points.insert(points.end(), ring.begin(), ring.end());
        control_points.insert(control_points.end(), control.begin(), control.end());
    }
};

// Whether two numbers, points or lists of points have the same bits: 0.0 and -0.0 differ.
bool same_bits(double a, double b);
bool same_bits(Vec3 a, Vec3 b);
bool same_bits(std::span<const Vec3> a, std::span<const Vec3> b);

// Whether all rings, points and control points are the same, bit for bit. O(points).
bool same_bits(const DrawnRings& a, const DrawnRings& b);

}  // namespace anatomesh
