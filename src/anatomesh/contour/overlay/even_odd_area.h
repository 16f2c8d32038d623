// even_odd_area: the area inside closed chains of segments, by the even-odd rule.
#pragma once

#include <vector>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

// Returns the area, within `clip`, of the points that a ray leaves through an odd number of segments. Requires: the
// segments close to cycles; they come in any order and direction, and may cross and overlap. The area is rounded: a
// segment that lies on another one adds at most its length times its distance from it. Complexity: O((n + k) (log n +
// a)) for n segments with k crossings, a of them at one height.
double even_odd_area(std::vector<Segment2> segments, const Box2& clip);

}  // namespace anatomesh
