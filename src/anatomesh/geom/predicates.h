// Exact geometric predicates: the sign is that of exact arithmetic on the given doubles, always.
#pragma once

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Positive if a, b, c run counter-clockwise, negative if clockwise, 0 if collinear.
int orient2d(Vec2 a, Vec2 b, Vec2 c);

// Positive if the cell (a, b, c, d) is positively oriented: dot(cross(b - a, c - a), d - a) > 0.
int orient3d(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// Positive if e lies inside the sphere through the positively oriented cell (a, b, c, d), 0 if on it.
int in_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e);

}  // namespace anatomesh
