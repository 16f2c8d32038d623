// trace_in_plane: where a field's surface cuts a plane, as the boundary of a region.
#pragma once

#include <functional>
#include <vector>

#include "anatomesh/field/slice/scanline.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

// The boundary of where `value` is negative in the box, on a lattice of about that step: closed, without
// crossings, region on the left, straight in each of the triangles that the lattice's squares are halved into
// (marching triangles), its points within a thousandth of a step. The rim of the box counts as outside.
// `value` is called from several threads. Requires: step > 0; a box with an area. Complexity: one value a
// lattice point, and some for each point of the boundary.
std::vector<Edge2> trace_in_plane(const std::function<double(Vec2)>& value, const Box2& box, double step,
                                  int threads);

// The loops of such a boundary as points of the plane, the region on their left; each begins at its lexicographically
// smallest vertex. Edges without length are passed over. O(n log n).
std::vector<std::vector<Vec3>> loops_in_plane(const std::vector<Edge2>& edges, const Plane& plane);

}  // namespace anatomesh
