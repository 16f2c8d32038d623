#include "anatomesh/contour/resolve/close_loops.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "anatomesh/contour/overlay/nesting.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_pen_slips =
    100'000;  // More crossings than this are not looked at. [crossings; > 0; B]

bool crosses_itself(const Ring& ring) {
    const std::span<const Ring> alone(&ring, 1);
    return !keep_apart(RingEdges(alone), alone);
}

bool draws_in(const Box2& box, const Ring& other) {
    return std::any_of(other.at.begin(), other.at.end(), [&](Vec2 p) { return box.contains(p); });
}

std::vector<Vec3> sorted_points(std::vector<Vec3> points) {
    std::sort(points.begin(), points.end(), LexicographicLess{});
    return points;
}

}  // namespace

std::optional<ClosedLoops> close_loops(const Ring& ring, std::span<const Ring> others, const Plane& plane,
                                       CombineRule rule, double share, const CloseLoopsOptions& options) {
    if (options.most_mm2 == 0 || !crosses_itself(ring)) return std::nullopt;
    std::optional<Combined> combined =
        combine_rings(std::span<const Ring>(&ring, 1), plane, rule, share, most_pen_slips);
    if (!combined || combined->rings.size() < 2 ||
        !(combined->fates.front().ambiguous_area_mm2 >
          area_rounding_share * combined->fates.front().area_mm2))
        return std::nullopt;
    std::vector<Ring>& rings = combined->rings;
    const auto area = [](const Ring& each) { return std::abs(signed_area(each.at)); };
    std::iter_swap(rings.begin(),
                   std::max_element(rings.begin(), rings.end(),
                                    [&](const Ring& a, const Ring& b) { return area(a) < area(b); }));
    ClosedLoops closed;
    for (std::size_t r = 1; r < rings.size(); ++r) {
        if (area(rings[r]) >= options.most_mm2) return std::nullopt;
        closed.area_mm2 += area(rings[r]);
        Box2 box;
        for (const Vec2 p : rings[r].at) box.extend(p);
        if (std::any_of(others.begin(), others.end(), [&](const Ring& other) {
                return other.source != ring.source && draws_in(box, other);
            }))
            return std::nullopt;
    }
    if (closed.area_mm2 > options.most_of_region * area(rings.front())) return std::nullopt;
    closed.loops = static_cast<std::uint32_t>(rings.size() - 1);
    closed.ring = std::move(rings.front());
    closed.ring.source = ring.source;
    closed.ring.plane = ring.plane;
    const std::vector<Vec3> drawn = sorted_points(ring.points);
    closed.crossings = static_cast<std::uint32_t>(std::count_if(
        closed.ring.points.begin(), closed.ring.points.end(),
        [&](Vec3 p) { return !std::binary_search(drawn.begin(), drawn.end(), p, LexicographicLess{}); }));
    closed.points_dropped = static_cast<std::uint32_t>(ring.size() - (closed.ring.size() - closed.crossings));
    return closed;
}

}  // namespace anatomesh
