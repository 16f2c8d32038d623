#include "anatomesh/contour/resolve/doubled_rings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// Rings nearer than this share of their mean edge length are one outline drawn twice. [1; > 0; M 2026-11, set not
// recorded]
constexpr double of_mean_edge = 0.5;

struct Outline {
    Box2 box;
    double area = 0, perimeter = 0, mean_edge = 0;

    explicit Outline(const Ring& ring)
        : area(std::abs(signed_area(ring.at))),
          perimeter(anatomesh::perimeter(ring.at)),
          mean_edge(perimeter / static_cast<double>(ring.size())) {
        for (Vec2 p : ring.at) box.extend(p);
    }

    double radius() const { return perimeter > 0 ? 2 * area / perimeter : 0; }
};

// Whether boxes and areas allow that the two keep within `within` of each other.
bool may_keep_near(const Outline& a, const Outline& b, double within) {
    return std::abs(a.box.low.x - b.box.low.x) <= within && std::abs(a.box.low.y - b.box.low.y) <= within &&
           std::abs(a.box.high.x - b.box.high.x) <= within &&
           std::abs(a.box.high.y - b.box.high.y) <= within &&
           std::abs(a.area - b.area) <= within * (a.perimeter + b.perimeter);
}

double squared_distance(Vec2 p, const Segment2& segment) {
    const Vec2 along = segment.b - segment.a, to = p - segment.a;
    const double length = dot(along, along);
    const double t = length > 0 ? std::clamp(dot(to, along) / length, 0.0, 1.0) : 0.0;
    const Vec2 off = to - t * along;
    return dot(off, off);
}

// Returns the largest distance from a vertex of `from` to `to`; infinite where one is further than `within`.
double farthest_vertex(const Ring& from, const Ring& to, double within) {
    // The index holds diagonals of the squares about the vertices, then the edges; pairs of both kinds count.
    std::vector<Segment2> items;
    for (Vec2 p : from.at) items.push_back({p - Vec2{within, within}, p + Vec2{within, within}});
    for (std::size_t v = 0; v < to.size(); ++v) items.push_back({to.at[v], to.at[(v + 1) % to.size()]});
    std::vector<double> nearest(from.size(), std::numeric_limits<double>::infinity());
    SegmentIndex(std::move(items)).for_each_near_pair([&](std::uint32_t vertex, std::uint32_t item) {
        if (vertex < from.size() && item >= from.size()) {
            const std::size_t edge = item - from.size();
            const Segment2 segment{to.at[edge], to.at[(edge + 1) % to.size()]};
            nearest[vertex] = std::min(nearest[vertex], squared_distance(from.at[vertex], segment));
        }
        return true;
    });
    const double most = *std::max_element(nearest.begin(), nearest.end());
    return most <= within * within ? std::sqrt(most) : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<DoubledRings> find_doubled_rings(std::span<const Ring> rings, double within_mm,
                                             double of_radius) {
    const std::vector<Outline> outlines(rings.begin(), rings.end());
    std::vector<std::uint32_t> by_left(rings.size());
    std::iota(by_left.begin(), by_left.end(), 0u);
    std::sort(by_left.begin(), by_left.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(outlines[a].box.low.x, a) < std::pair(outlines[b].box.low.x, b);
    });
    const auto descends = [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(-outlines[a].area, a) < std::pair(-outlines[b].area, b);
    };
    std::vector<DoubledRings> doubled;
    for (std::size_t i = 0; i < by_left.size(); ++i) {
        for (std::size_t j = i + 1; j < by_left.size(); ++j) {
            const std::uint32_t a = by_left[i], b = by_left[j];
            if (outlines[b].box.low.x - outlines[a].box.low.x > within_mm) break;
            const double edge = std::min(outlines[a].mean_edge, outlines[b].mean_edge);
            const double radius = std::min(outlines[a].radius(), outlines[b].radius());
            const double within = std::min(within_mm, std::max(of_mean_edge * edge, of_radius * radius));
            if (rings[a].plane != rings[b].plane || !may_keep_near(outlines[a], outlines[b], within))
                continue;
            const double apart = std::max(farthest_vertex(rings[a], rings[b], within),
                                          farthest_vertex(rings[b], rings[a], within));
            if (apart > within) continue;
            doubled.push_back(descends(a, b) ? DoubledRings{b, a, apart} : DoubledRings{a, b, apart});
        }
    }
    std::sort(doubled.begin(), doubled.end(), [&](const DoubledRings& a, const DoubledRings& b) {
        if (a.smaller != b.smaller) return descends(a.smaller, b.smaller);
        return descends(a.larger, b.larger);
    });
    return doubled;
}

}  // namespace anatomesh
