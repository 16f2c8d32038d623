// Where outlines of two neighbouring slices overlap so that it is not determined which becomes which.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/field/motion/boundary_pieces.h"

namespace anatomesh {

// Outlines that hang together by overlapping, as seen along the normal: several on each slice, and not as
// many on the one as on the other. (One that becomes several, or several that become one, is a branching like
// any.)
struct Ambiguity {
    std::uint32_t below = 0, above = 0;  // how many
    Vec2 at;                             // the middle of their box
};

// Those of two regions, in the order of their first outlines below. Two outlines overlap if one of (128 of)
// the boundary points of the one lies in what the other bounds. Complexity: linear where one of the slices
// shows one outline alone, else O(k n) for k outlines.
std::vector<Ambiguity> ambiguities(const BoundarySide& below, const DistanceMap& below_map,
                                   const BoundarySide& above, const DistanceMap& above_map);

}  // namespace anatomesh
