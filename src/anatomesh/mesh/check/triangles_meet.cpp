#include "anatomesh/mesh/check/triangles_meet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

using Corners = std::array<Vec3, 3>;

Vec2 drop_axis(Vec3 p, int axis) {
    return axis == 0 ? Vec2{p.y, p.z} : axis == 1 ? Vec2{p.z, p.x} : Vec2{p.x, p.y};
}

// An axis along which the triangle does not project to a segment, so that its plane maps one to one.
int projection_axis(const Corners& t) {
    int axis = 0;
    while (axis < 2 && orient2d(drop_axis(t[0], axis), drop_axis(t[1], axis), drop_axis(t[2], axis)) == 0)
        ++axis;
    return axis;
}

bool point_in_triangle(Vec2 p, Vec2 a, Vec2 b, Vec2 c) {
    const int s = orient2d(a, b, p), t = orient2d(b, c, p), u = orient2d(c, a, p);
    return (s >= 0 && t >= 0 && u >= 0) || (s <= 0 && t <= 0 && u <= 0);
}

bool between(double a, double b, double p) {
    return (a <= p && p <= b) || (b <= p && p <= a);
}

// Closed segments in the plane.
bool segments_meet(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    const int ca = orient2d(a, b, c), da = orient2d(a, b, d), ac = orient2d(c, d, a), bc = orient2d(c, d, b);
    if (ca * da < 0 && ac * bc < 0) return true;
    const auto on = [](Vec2 p, Vec2 q, Vec2 r) { return between(p.x, q.x, r.x) && between(p.y, q.y, r.y); };
    return (ca == 0 && on(a, b, c)) || (da == 0 && on(a, b, d)) || (ac == 0 && on(c, d, a)) ||
           (bc == 0 && on(c, d, b));
}

bool coplanar_segment_meets(Vec3 a, Vec3 b, const Corners& t) {
    const int axis = projection_axis(t);
    const Vec2 p = drop_axis(a, axis), q = drop_axis(b, axis);
    const std::array<Vec2, 3> f{drop_axis(t[0], axis), drop_axis(t[1], axis), drop_axis(t[2], axis)};
    if (point_in_triangle(p, f[0], f[1], f[2])) return true;
    for (std::size_t i = 0; i < 3; ++i) {
        if (segments_meet(p, q, f[i], f[(i + 1) % 3])) return true;
    }
    return false;
}

// Closed segment (a, b) and closed triangle; side_a and side_b are the sides of a and b on the triangle's
// plane.
bool segment_meets(Vec3 a, Vec3 b, int side_a, int side_b, const Corners& t) {
    if (side_a * side_b > 0) return false;
    if (side_a == 0 && side_b == 0) return coplanar_segment_meets(a, b, t);
    const int s = orient3d(a, b, t[0], t[1]), u = orient3d(a, b, t[1], t[2]), v = orient3d(a, b, t[2], t[0]);
    return (s >= 0 && u >= 0 && v >= 0) || (s <= 0 && u <= 0 && v <= 0);
}

// Those of the first `common` corners, which are the plane's own, are 0.
std::array<int, 3> sides_of(const Corners& plane, const Corners& t, std::size_t common) {
    std::array<int, 3> sides{};
    for (std::size_t i = common; i < 3; ++i) sides[i] = orient3d(plane[0], plane[1], plane[2], t[i]);
    return sides;
}

bool all_on_one_side(const std::array<int, 3>& sides, std::size_t from) {
    bool above = true, below = true;
    for (std::size_t i = from; i < 3; ++i) {
        above = above && sides[i] > 0;
        below = below && sides[i] < 0;
    }
    return above || below;
}

// A number and how far it may be off by rounding.
struct Rounded {
    double value, error;
};

// u (p - origin). Differences of coordinates are right to the last bit, whatever the place.
Rounded along(Vec3 u, Vec3 p, Vec3 origin) {
    const Vec3 w = p - origin;
    const double x = u.x * w.x, y = u.y * w.y, z = u.z * w.z;
    using Limits = std::numeric_limits<double>;
    return {x + y + z, 4 * Limits::epsilon() * (std::abs(x) + std::abs(y) + std::abs(z)) + Limits::min()};
}

// Whether a plane square to u, through `origin` where that is the common vertex, has one triangle on each
// side of it beyond doubt. Any u is right, one from b to a most likely to find it.
bool is_plane_between(Vec3 u, Vec3 origin, const Corners& a, const Corners& b, std::size_t common) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (std::size_t i = common; i < 3; ++i) {
        const Rounded at_a = along(u, a[i], origin), at_b = along(u, b[i], origin);
        if (!std::isfinite(at_a.error) || !std::isfinite(at_b.error)) return false;
        least = std::min(least, at_a.value - at_a.error);
        most = std::max(most, at_b.value + at_b.error);
    }
    return common > 0 ? least > 0 && most < 0 : least > most;
}

// Two triangles without a common vertex: they meet exactly when an edge of one meets the other.
bool apart_triangles_meet(const Corners& a, const Corners& b) {
    const std::array<int, 3> a_sides = sides_of(b, a, 0);
    if (all_on_one_side(a_sides, 0)) return false;
    const std::array<int, 3> b_sides = sides_of(a, b, 0);
    if (all_on_one_side(b_sides, 0)) return false;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        if (segment_meets(a[i], a[j], a_sides[i], a_sides[j], b)) return true;
        if (segment_meets(b[i], b[j], b_sides[i], b_sides[j], a)) return true;
    }
    return false;
}

// Triangles with the common vertex a[0] = b[0]. What they share is star-shaped about it, and its far end lies
// on the opposite edge of one of them.
bool touching_triangles_meet(const Corners& a, const Corners& b) {
    const std::array<int, 3> a_sides = sides_of(b, a, 1);
    if (all_on_one_side(a_sides, 1)) return false;
    const std::array<int, 3> b_sides = sides_of(a, b, 1);
    if (all_on_one_side(b_sides, 1)) return false;
    return segment_meets(a[1], a[2], a_sides[1], a_sides[2], b) ||
           segment_meets(b[1], b[2], b_sides[1], b_sides[2], a);
}

// Triangles with the common edge a[0] a[1] = b[0] b[1]: they meet beyond it when one is folded onto the
// other.
bool hinged_triangles_meet(const Corners& a, const Corners& b) {
    if (orient3d(a[0], a[1], a[2], b[2]) != 0) return false;
    const int axis = projection_axis(a);
    const Vec2 p = drop_axis(a[0], axis), q = drop_axis(a[1], axis);
    return orient2d(p, q, drop_axis(a[2], axis)) == orient2d(p, q, drop_axis(b[2], axis));
}

}  // namespace

bool triangles_meet(std::span<const Vec3> points, const Triangle& a, const Triangle& b) {
    // Common vertices first, in both.
    Triangle p = a, q = b;
    std::size_t common = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = common; j < 3; ++j) {
            if (p[i] != q[j]) continue;
            std::swap(p[common], p[i]);
            std::swap(q[common], q[j]);
            ++common;
            break;
        }
    }
    const Corners pc{points[p[0]], points[p[1]], points[p[2]]}, qc{points[q[0]], points[q[1]], points[q[2]]};
    // Most pairs lie side by side: that takes no exact sign.
    if (common < 2) {
        const Vec3 origin = pc[0];
        const Vec3 to_a = (pc[1] - origin) + (pc[2] - origin),
                   to_b = (qc[0] - origin) + (qc[1] - origin) + (qc[2] - origin);
        const Vec3 u = common == 0 ? to_a - to_b : (1 / length(to_a)) * to_a - (1 / length(to_b)) * to_b;
        if (is_plane_between(u, origin, pc, qc, common)) return false;
    }
    switch (common) {
        case 0:
            return apart_triangles_meet(pc, qc);
        case 1:
            return touching_triangles_meet(pc, qc);
        case 2:
            return hinged_triangles_meet(pc, qc);
        default:
            return true;
    }
}

}  // namespace anatomesh
