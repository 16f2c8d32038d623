// Whether two triangles meet anywhere but where they are allowed to: exact.
#pragma once

#include <span>

#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

// True when the closed triangles a and b have a point in common beyond the vertex or edge that they share by
// index. Triangles with the same three vertices always do. Requires: neither is degenerate (collinear).
// Exact: decided by orient2d and orient3d alone.
bool triangles_meet(std::span<const Vec3> points, const Triangle& a, const Triangle& b);

}  // namespace anatomesh
