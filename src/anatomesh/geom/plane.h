// Plane: a plane in space with a right-handed frame (u, v, normal) and an origin.
#pragma once

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// u, v, normal are orthonormal and right-handed; (x, y) in the plane is origin + x u + y v.
struct Plane {
    Vec3 origin;
    Vec3 u{1, 0, 0}, v{0, 1, 0}, normal{0, 0, 1};

    Vec2 to_plane(Vec3 p) const { return {dot(p - origin, u), dot(p - origin, v)}; }
    Vec3 to_space(Vec2 q) const { return origin + q.x * u + q.y * v; }
    double signed_distance(Vec3 p) const { return dot(p - origin, normal); }
};

// Returns the plane through `origin` with the given normal, of any length but 0. The frame depends on the normal alone:
// u is the axis least aligned with the normal, made orthogonal. For normal (0, 0, 1), u = x and v = y exactly.
Plane make_plane(Vec3 origin, Vec3 normal);

}  // namespace anatomesh
