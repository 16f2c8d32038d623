// slice_faults: where the contours of a slice are not what a kept contour set promises.
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

// The segments at fault, exactly: every ring has to be simple; rings of one structure (of all, if
// `exclusive`) may meet in nothing but common vertices of different structures and segments that these share;
// rings that bound their region from outside run counter-clockwise, holes clockwise (a ring that does not is
// named by its first segment). Empty: sound. Complexity: O(n log n) for contours that keep apart.
std::vector<RingSegment> slice_faults(std::span<const PlaneRing> rings, bool exclusive);

}  // namespace anatomesh
