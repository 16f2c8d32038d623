#include "anatomesh/geom/predicates.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <cmath>

namespace anatomesh {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(Vec3 p) { return {p.x, p.y, p.z}; }

// The unit roundoff of a double, and more than what the few products of a determinant may lose to underflow.
constexpr double roundoff = 0x1p-53;
constexpr double underflow = 0x1p-1070;

}  // namespace

int orient2d(Vec2 a, Vec2 b, Vec2 c) {
    // Filter: the error of the rounded determinant is below (3 + 16 u) u (|left| + |right|) (Shewchuk,
    // Discrete Comput. Geom. 18, 1997, section 4).
    const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
    const double determinant = left - right;
    const double error = 3.1 * roundoff * (std::abs(left) + std::abs(right)) + underflow;
    if (std::abs(determinant) > error) return determinant > 0 ? 1 : -1;
    return CGAL::orientation(Kernel::Point_2(a.x, a.y), Kernel::Point_2(b.x, b.y), Kernel::Point_2(c.x, c.y));
}

int orient3d(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    // Filter as in orient2d, with the bound (7 + 56 u) u times the permanent.
    const Vec3 p = a - d, q = b - d, r = c - d;
    const double qr = q.x * r.y, rq = r.x * q.y, rp = r.x * p.y, pr = p.x * r.y, pq = p.x * q.y, qp = q.x * p.y;
    const double determinant = p.z * (qr - rq) + q.z * (rp - pr) + r.z * (pq - qp);
    const double permanent = (std::abs(qr) + std::abs(rq)) * std::abs(p.z) +
                             (std::abs(rp) + std::abs(pr)) * std::abs(q.z) +
                             (std::abs(pq) + std::abs(qp)) * std::abs(r.z);
    const double error = 7.8 * roundoff * permanent + underflow * (1 + std::abs(p.z) + std::abs(q.z) + std::abs(r.z));
    if (std::abs(determinant) > error) return determinant < 0 ? 1 : -1;
    return CGAL::orientation(point(a), point(b), point(c), point(d));
}

int in_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e) {
    return CGAL::side_of_oriented_sphere(point(a), point(b), point(c), point(d), point(e));
}

}  // namespace anatomesh
