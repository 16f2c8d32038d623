// clip_area: the part of a drawn area that lies in a convex polygon, as in the picture of a slice.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/live/draw/area/structure_rings.h"

namespace anatomesh {

struct ClippedArea {
    std::vector<Ring> rings;  // simple where something was cut off, else the area's, bit for bit
    bool is_cut = false;      // a part of the area lay outside
};

// The area is the even-odd interior of its rings, which may cross. An empty `clip` is the whole plane. What
// lies outside by less than 1e-6 mm is inside. Vertices of the result are vertices or crossings of the two.
// Errors: those of check_points(); usage E-LIV-009 the clip has fewer than three points or is not convex; limit
// E-LIV-007 the edges cross too often. Complexity: that of arrange() where something is cut off, else O(n m).
Result<ClippedArea> clip_area(std::vector<Ring> area, std::span<const Vec2> clip, const Plane& plane);

}  // namespace anatomesh
