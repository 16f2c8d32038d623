// even_odd_area: the area inside closed chains of segments, by the even-odd rule.
#pragma once

#include <vector>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

// The area, within `clip`, of the points that a ray leaves through an odd number of segments. The segments,
// in any order and direction, close to cycles; they may cross and overlap. Rounded: a segment that lies on
// another adds at most its length times its distance from it. Complexity: O((n + k) (log n + a)) for n
// segments with k crossings, a of them at one height.
double even_odd_area(std::vector<Segment2> segments, const Box2& clip);

}  // namespace anatomesh
