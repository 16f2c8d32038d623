#include "anatomesh/geom/predicates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "anatomesh/geom/predicates_exact.h"

namespace anatomesh {

namespace {

// A sum or product of doubles is off by this share of it at most: the unit roundoff. [1; > 0; D IEEE 754]
constexpr double roundoff = 0x1p-53;
// The few products of a determinant lose less than this to underflow. [1; > 0; D]
constexpr double underflow = 0x1p-1070;

Vec3 larger(Vec3 a, Vec3 b) {
    return {std::max(a.x, std::abs(b.x)), std::max(a.y, std::abs(b.y)), std::max(a.z, std::abs(b.z))};
}

}  // namespace

int orient2d(Vec2 a, Vec2 b, Vec2 c) {
    // Filter: the error of the rounded determinant is below (3 + 16 u) u (|left| + |right|) (Shewchuk,
    // Discrete Comput. Geom. 18, 1997, section 4).
    const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
    const double determinant = left - right;
    const double error = 3.1 * roundoff * (std::abs(left) + std::abs(right)) + underflow;
    if (std::abs(determinant) > error) return determinant > 0 ? 1 : -1;
    return exact::orient2d(a, b, c);
}

int orient3d(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    // Filter as in orient2d, with the bound (7 + 56 u) u times the permanent.
    const Vec3 p = a - d, q = b - d, r = c - d;
    const double qr = q.x * r.y, rq = r.x * q.y, rp = r.x * p.y, pr = p.x * r.y, pq = p.x * q.y,
                 qp = q.x * p.y;
    const double determinant = p.z * (qr - rq) + q.z * (rp - pr) + r.z * (pq - qp);
    const double permanent = (std::abs(qr) + std::abs(rq)) * std::abs(p.z) +
                             (std::abs(rp) + std::abs(pr)) * std::abs(q.z) +
                             (std::abs(pq) + std::abs(qp)) * std::abs(r.z);
    const double error =
        7.8 * roundoff * permanent + underflow * (1 + std::abs(p.z) + std::abs(q.z) + std::abs(r.z));
    if (std::abs(determinant) > error) return determinant < 0 ? 1 : -1;
    // Slices are often planes of one coordinate.
    const auto all_zero = [](double x, double y, double z) { return x == 0 && y == 0 && z == 0; };
    if (all_zero(p.x, q.x, r.x) || all_zero(p.y, q.y, r.y) || all_zero(p.z, q.z, r.z)) return 0;
    return exact::orient3d(a, b, c, d);
}

int in_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e) {
    const Vec3 p = b - a, q = c - a, r = d - a, t = e - a;
    const Vec3 qr = cross(q, r);
    const Vec3 normal =
        squared_length(p) * qr + squared_length(q) * cross(r, p) + squared_length(r) * cross(p, q);
    const double determinant = dot(normal, t) - dot(p, qr) * squared_length(t);
    const RoundingBounds bounds = rounding_bounds(larger(larger(larger(larger({}, p), q), r), t));
    if (std::abs(determinant) > bounds.in_sphere) return determinant > 0 ? 1 : -1;
    return exact::in_sphere(a, b, c, d, e);
}

int in_perturbed_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e) {
    if (const int sign = in_sphere(a, b, c, d, e)) return sign;
    // Point i, raised on the paraboloid by epsilon_i, changes the determinant by epsilon_i times an orientation. The
    // largest epsilon whose factor is not zero decides. To raise e itself takes it out of the sphere.
    const std::array<Vec3, 4> cell{a, b, c, d};
    std::array<int, 4> order{0, 1, 2, 3};
    std::sort(order.begin(), order.end(), [&](int i, int j) { return lexicographic_less(cell[j], cell[i]); });
    for (const int i : order) {
        if (!lexicographic_less(e, cell[i])) return -1;
        std::array<Vec3, 4> changed = cell;
        changed[i] = e;
        if (const int sign = orient3d(changed[0], changed[1], changed[2], changed[3])) return sign;
    }
    return -1;
}

RoundingBounds rounding_bounds(Vec3 extent) {
    // A determinant has n! products of differences, each with at most k roundings between coordinates and result. It is
    // off by at most k u n! times the largest product; here k = 8 and n! = 6, or k = 17 and n! = 24.
    // The last 1/400 is for the products of errors. Underflow adds at most 2^-1060 times what a lost product
    // is multiplied by.
    const double largest = std::max({extent.x, extent.y, extent.z}), squares = squared_length(extent);
    if (!(largest <= 0x1p200)) {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        return {infinity, infinity, infinity};
    }
    const double volume = extent.x * extent.y * extent.z, factor = (1 + largest) * (1 + largest);
    const double lost = 0x1p-1060 * (factor * factor);
    return {48.12 * roundoff * volume + 0x1p-1060 * factor, in_sphere_rounding * (volume * squares) + lost,
            lost};
}

}  // namespace anatomesh
