#include "anatomesh/slices/arrangement/mirrored_frame.h"

namespace anatomesh {

Plane mirrored_frame(const Plane& from, const Plane& to) {
    const Vec3 across = from.normal + to.normal;
    const double size = squared_length(across);
    const auto turned = [&](Vec3 v) { return v - (2 * dot(v, across) / size) * across; };
    const double sum = from.signed_distance(from.origin) + to.signed_distance(from.origin);
    Plane plane;
    plane.normal = to.normal;
    plane.origin = from.origin - (2 * sum / size) * across;
    // Onto the plane, and at right angles, to the last bit but one.
    plane.origin = plane.origin - to.signed_distance(plane.origin) * to.normal;
    const Vec3 u = turned(from.u);
    plane.u = normalized(u - dot(u, to.normal) * to.normal);
    plane.v = cross(plane.normal, plane.u);
    return plane;
}

}  // namespace anatomesh
