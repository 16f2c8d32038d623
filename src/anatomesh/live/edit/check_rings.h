// check_rings: whether rings can stand on a plane.
#pragma once

#include <span>

#include "anatomesh/base/result.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/live/edit/drawn_rings.h"
#include "anatomesh/live/edit/edit.h"

namespace anatomesh {

// Every coordinate has to be finite and within 1e7 mm, every ring to have three points or more, and every point and control
// point to lie within 0.01 mm of the plane. With CrossingCheck::yes rings must not cross and not share a stretch, while they
// may touch at points; that is decided exactly, on the plane's coordinates of the points. `place` says where, for messages.
// Errors: E-EDT-005 to -008. Complexity: O(points), with crossings O(points log points) for rings that keep apart.
Status check_rings(const DrawnRings& rings, const Plane& plane, CrossingCheck crossings, const Place& place);

// Whether a coordinate is finite and within 1e7 mm.
bool is_possible(Vec3 p);

}  // namespace anatomesh
