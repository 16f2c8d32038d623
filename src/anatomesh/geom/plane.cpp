#include "anatomesh/geom/plane.h"

#include <cassert>
#include <cmath>

namespace anatomesh {

Plane make_plane(Vec3 origin, Vec3 normal) {
    assert(squared_length(normal) > 0);
    const Vec3 n = normalized(normal);
    // The least aligned axis; ties go to x, then y, so that an axial plane has u = x, v = y.
    const double ax = std::abs(n.x), ay = std::abs(n.y), az = std::abs(n.z);
    const Vec3 axis = ax <= ay && ax <= az ? Vec3{1, 0, 0} : ay <= az ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    const Vec3 u = normalized(axis - dot(axis, n) * n);
    return {origin, u, cross(n, u), n};
}

}  // namespace anatomesh
