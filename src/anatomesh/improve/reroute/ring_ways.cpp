#include "anatomesh/improve/reroute/ring_ways.h"

namespace anatomesh {

RingWithWays with_ways(const RoutedRing& ring) {
    RingWithWays whole;
    const auto add = [&](std::uint32_t v, std::size_t way) {
        whole.vertices.push_back(v);
        whole.way_of.push_back(way);
    };
    // From a way on, the last one may end beyond the ring's own end.
    std::size_t next = 0;
    const std::uint32_t start = ring.ways.empty() ? 0 : ring.ways.front().first;
    for (std::uint32_t k = 0; k < ring.size();) {
        const std::uint32_t n = (start + k) % ring.size();
        if (next == ring.ways.size() || ring.ways[next].first != n) {
            add(ring.vertices[n], ring.ways.size());
            ++k;
            continue;
        }
        add(ring.vertices[n], next);
        for (const std::uint32_t v : ring.ways[next].between) add(v, next);
        k += ring.ways[next].count;
        ++next;
    }
    return whole;
}

}  // namespace anatomesh
