#include "anatomesh/live/edit/drawn_rings.h"

#include <algorithm>
#include <bit>

namespace anatomesh {

bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool same_bits(Vec3 a, Vec3 b) {
    return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z);
}

bool same_bits(std::span<const Vec3> a, std::span<const Vec3> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](Vec3 p, Vec3 q) { return same_bits(p, q); });
}

bool same_bits(const DrawnRings& a, const DrawnRings& b) {
    const auto alike = [](const DrawnRing& p, const DrawnRing& q) {
        return p.tool == q.tool && p.first_point == q.first_point && p.point_count == q.point_count &&
               p.first_control == q.first_control && p.control_count == q.control_count;
    };
    return std::equal(a.rings.begin(), a.rings.end(), b.rings.begin(), b.rings.end(), alike) &&
           same_bits(std::span<const Vec3>(a.points), std::span<const Vec3>(b.points)) &&
           same_bits(std::span<const Vec3>(a.control_points), std::span<const Vec3>(b.control_points));
}

}  // namespace anatomesh
