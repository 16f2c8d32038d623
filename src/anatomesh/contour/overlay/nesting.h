// Nesting of rings that keep apart: which ring lies in which.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/ring.h"
#include "anatomesh/contour/overlay/segment_index.h"

namespace anatomesh {

// The edges of many rings, one ring after the other. Segment s is the edge of ring ring_of[s] from its vertex
// s - first[ring_of[s]] to the next.
struct RingEdges {
    std::vector<std::uint32_t> first;    // per ring
    std::vector<std::uint32_t> ring_of;  // per segment
    SegmentIndex index;

    explicit RingEdges(std::span<const Ring> rings);
};

// Whether every ring is simple and no two touch. So only consecutive edges have a point in common, which is their
// common vertex. Exact. Requires: rings of three vertices or more, no zero-length edge. O(n log n + near pairs).
bool keep_apart(const RingEdges& edges, std::span<const Ring> rings);

struct Nesting {
    std::vector<std::uint32_t> depth;  // per ring: how many rings it lies in; even: outer, odd: hole
    std::vector<std::int32_t> parent;  // the innermost of those, or -1
};

// Finds the rings that each ring lies in. Requires: keep_apart(edges, rings). O(n log n + rays' hits).
Nesting nest(const RingEdges& edges, std::span<const Ring> rings);

}  // namespace anatomesh
