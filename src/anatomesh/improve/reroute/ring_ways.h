// RoutedRing: a contour, some segments of which are replaced by ways over edges of the surface.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace anatomesh {

// Replaces some segments of a ring, one after the other.
struct RingWay {
    std::uint32_t first = 0, count = 1;  // segments
    std::uint32_t missed = 0;            // the segment for whose sake it was sought
    std::uint32_t replaced = 0;          // segments that are missed
    std::vector<std::uint32_t> between;  // vertices, without the ends
    double farthest_mm = 0;              // of the way from the segments, and of these from it
};

struct RoutedRing {
    std::vector<std::uint32_t> vertices;
    std::vector<RingWay> ways;  // by first segment, rising

    std::uint32_t size() const { return static_cast<std::uint32_t>(vertices.size()); }
    // The n-th vertex, modulo the size.
    std::uint32_t vertex(std::uint32_t n) const { return vertices[n % size()]; }
    // How far segment n is after the first one of a way.
    std::uint32_t steps(const RingWay& way, std::uint32_t n) const {
        return (n + size() - way.first) % size();
    }
    bool is_rerouted(std::uint32_t n) const {
        return std::any_of(ways.begin(), ways.end(),
                           [&](const RingWay& way) { return steps(way, n) < way.count; });
    }
};

// All vertices, and for each segment between them the index of the way that it is of, or the number of ways.
struct RingWithWays {
    std::vector<std::uint32_t> vertices;
    std::vector<std::size_t> way_of;
};

// O(vertices)
RingWithWays with_ways(const RoutedRing& ring);

}  // namespace anatomesh
