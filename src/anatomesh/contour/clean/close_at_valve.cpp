#include "anatomesh/contour/clean/close_at_valve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace anatomesh {

namespace {

// A gap wider than this share of what is drawn of a chamber is no valve. [1; 0 to 1; M 2026-11 hearts]
constexpr double most_gap = 0.5;
// What passes the plane farther beside the gap than this share of it is something else. [1; 0 to 1; M 2026-11 hearts]
constexpr double beside_gap = 0.25;

}  // namespace

std::optional<ValveClosing> close_at_valve(std::span<const Vec3> drawn,
                                           std::span<const std::span<const Vec3>> others) {
    ValveClosing closing;
    const Vec3 from = drawn.back(), to = drawn.front();
    double length_drawn = 0;
    Vec3 area;  // Newell's normal, about one of the ends
    for (std::size_t n = 1; n < drawn.size(); ++n) {
        length_drawn += length(drawn[n] - drawn[n - 1]);
        area += cross(drawn[n - 1] - from, drawn[n] - from);
    }
    closing.gap_mm = length(to - from);
    if (!(closing.gap_mm > 0) || closing.gap_mm > most_gap * length_drawn || length(area) == 0)
        return std::nullopt;
    const Vec3 normal = normalized(area), along = (1 / closing.gap_mm) * (to - from);
    // Away from what is drawn: it runs round the normal counter-clockwise, and the closing edge with it.
    const Vec3 outward = normalized(cross(along, normal));
    for (const std::span<const Vec3> other : others) {
        for (std::size_t n = 0; n < other.size(); ++n) {
            const Vec3 p = other[n], q = other[(n + 1) % other.size()];
            const double at_p = dot(p - from, normal), at_q = dot(q - from, normal);
            if ((at_p > 0) == (at_q > 0)) continue;
            const Vec3 x = p + (at_p / (at_p - at_q)) * (q - p);
            const double share = dot(x - from, along) / closing.gap_mm, beyond = dot(x - from, outward);
            if (share < -beside_gap || share > 1 + beside_gap || beyond > closing.gap_mm) continue;
            closing.beyond_mm = std::max(closing.beyond_mm, beyond);
        }
    }
    if (closing.beyond_mm == 0) return closing;
    const double step = length_drawn / static_cast<double>(drawn.size() - 1);
    const Vec3 lift = (closing.beyond_mm + step) * outward;
    closing.between = {from + lift, to + lift};
    return closing;
}

}  // namespace anatomesh
