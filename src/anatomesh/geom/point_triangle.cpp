#include "anatomesh/geom/point_triangle.h"

#include <algorithm>
#include <cmath>

namespace anatomesh {

namespace {

double segment_squared_distance(Vec3 p, Vec3 a, Vec3 b) {
    const Vec3 ab = b - a;
    const double along = dot(p - a, ab), whole = squared_length(ab);
    if (along <= 0 || whole == 0) return squared_length(p - a);
    if (along >= whole) return squared_length(p - b);
    return squared_length(p - a - (along / whole) * ab);
}

}  // namespace

double point_triangle_squared_distance(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
    const Vec3 ab = b - a, ac = c - a, normal = cross(ab, ac);
    const double area = squared_length(normal);
    if (area > 0) {
        // Barycentric coordinates of the foot of the perpendicular, times the squared area.
        const Vec3 ap = p - a;
        const double v = dot(cross(ap, ac), normal), w = dot(cross(ab, ap), normal);
        if (v >= 0 && w >= 0 && v + w <= area) {
            const double height = dot(ap, normal);
            return height * height / area;
        }
    }
    return std::min({segment_squared_distance(p, a, b), segment_squared_distance(p, b, c),
                     segment_squared_distance(p, c, a)});
}

double point_segment_distance(Vec3 p, Vec3 a, Vec3 b) {
    return std::sqrt(segment_squared_distance(p, a, b));
}

double point_triangle_distance(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
    return std::sqrt(point_triangle_squared_distance(p, a, b, c));
}

}  // namespace anatomesh
