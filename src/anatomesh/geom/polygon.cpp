#include "anatomesh/geom/polygon.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "anatomesh/geom/predicates.h"

namespace anatomesh {

double signed_area(std::span<const Vec2> polygon) {
    if (polygon.size() < 3) return 0;
    double twice = 0;
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
        twice += cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
    }
    return 0.5 * twice;
}

double perimeter(std::span<const Vec2> polygon) {
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        sum += length(polygon[(i + 1) % polygon.size()] - polygon[i]);
    }
    return sum;
}

Side side_of_polygon(std::span<const Vec2> polygon, Vec2 point) {
    bool inside = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        Vec2 a = polygon[i], b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        if (on_segment(a, b, point)) return Side::on_boundary;
        // A ray towards -y; the half-open rule counts a vertex on the ray once or not at all.
        if ((a.x <= point.x) == (b.x <= point.x)) continue;
        if (a.x > b.x) std::swap(a, b);
        if (orient2d(a, b, point) > 0) inside = !inside;
    }
    return inside ? Side::inside : Side::outside;
}

double distance_to_segment(Vec2 p, Vec2 a, Vec2 b) {
    const double square = squared_length(b - a);
    const double t = square > 0 ? std::clamp(dot(p - a, b - a) / square, 0.0, 1.0) : 0.0;
    return length(p - (a + t * (b - a)));
}

bool on_segment(Vec2 a, Vec2 b, Vec2 p) {
    if (p.x < std::min(a.x, b.x) || p.x > std::max(a.x, b.x)) return false;
    if (p.y < std::min(a.y, b.y) || p.y > std::max(a.y, b.y)) return false;
    return orient2d(a, b, p) == 0;
}

SegmentContact segment_contact(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    assert(a != b && c != d);
    const int abc = orient2d(a, b, c), abd = orient2d(a, b, d);
    if (abc * abd > 0) return SegmentContact::none;
    const int cda = orient2d(c, d, a), cdb = orient2d(c, d, b);
    if (cda * cdb > 0) return SegmentContact::none;
    if (abc == 0 && abd == 0) {
        // On one line: compare the intervals in lexicographic order, which is monotone along it.
        if (lexicographic_less(b, a)) std::swap(a, b);
        if (lexicographic_less(d, c)) std::swap(c, d);
        const Vec2 low = lexicographic_less(a, c) ? c : a, high = lexicographic_less(b, d) ? b : d;
        if (lexicographic_less(high, low)) return SegmentContact::none;
        return low == high ? SegmentContact::touch : SegmentContact::overlap;
    }
    return abc != 0 && abd != 0 && cda != 0 && cdb != 0 ? SegmentContact::cross : SegmentContact::touch;
}

}  // namespace anatomesh
