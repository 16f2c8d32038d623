// copy_rings: the rings of one plane on another one.
#pragma once

#include "anatomesh/live/draw/area/structure_rings.h"

namespace anatomesh {

// Returns the rings with the same in-plane coordinates on the plane `to`, in their order. On a parallel plane of one frame
// each point moves along the normal; on a turned plane the picture turns with the frame. What a point was off its
// plane is left behind. Requires: sound rings. Errors: those of check_structure_rings() for the copy: the plane may be
// bad, and rounding far from the origin may let rings touch. O(n log n).
Result<StructureRings> copy_rings(const StructureRings& from, const Plane& to);

}  // namespace anatomesh
