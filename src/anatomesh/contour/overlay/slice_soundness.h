// slice_faults: the segments at which the contours of a slice break the invariants of a kept set.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// A ring of points in its plane, with the structure it belongs to.
struct PlaneRing {
    std::uint32_t structure = 0;
    std::vector<Vec2> at;
};

// The contours of a slice, in their order. O(n).
std::vector<PlaneRing> plane_rings(const ContourSet& set, const Slice& slice);

// A segment of a ring, by its first point.
struct RingSegment {
    std::uint32_t ring = 0, place = 0;
};

// Returns the segments at fault, by exact predicates; none for a sound slice. Every ring has to be simple. Rings of one
// structure must not meet. Rings of different structures may meet in common vertices and shared segments only, if
// `exclusive`. Outer rings run counter-clockwise and holes clockwise; a ring that does not is named by its first
// segment. Complexity: O(n log n) for contours that keep apart.
std::vector<RingSegment> slice_faults(std::span<const PlaneRing> rings, bool exclusive);

}  // namespace anatomesh
