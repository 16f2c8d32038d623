// Solids cut by planes about an axis, for the tests of this room.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/field_fixtures.h"

namespace anatomesh::fixtures {

// Planes about an axis, of a frame whose normal it is, at angles of radians from the frame's u.
inline Plane plane_about(const Plane& axis, double angle) {
    return make_plane(axis.origin, std::cos(angle) * axis.v - std::sin(angle) * axis.u);
}

inline std::vector<Plane> planes_about(const Plane& axis, int count) {
    std::vector<Plane> planes;
    for (int k = 0; k < count; ++k) planes.push_back(plane_about(axis, std::numbers::pi * k / count));
    return planes;
}

// In any order, every second one the other way round.
inline std::vector<Plane> in_any_order(std::vector<Plane> planes, std::mt19937& random) {
    for (std::size_t k = 0; k < planes.size(); k += 2)
        planes[k].normal = -1.0 * planes[k].normal, planes[k].v = -1.0 * planes[k].v;
    std::shuffle(planes.begin(), planes.end(), random);
    return planes;
}

// As if the probe were held by hand: each beside its place by up to so much, and leaning by up to so many
// radians.
inline std::vector<Plane> beside_their_places(std::vector<Plane> planes, double most_mm, double most_lean,
                                              std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1);
    for (Plane& plane : planes) {
        const Vec3 lean{unit(random), unit(random), unit(random)};
        plane = make_plane(plane.origin + most_mm * unit(random) * plane.normal,
                           plane.normal + (most_lean / std::sqrt(3.0)) * lean);
    }
    return planes;
}

// An ellipsoid by its half axes along x, y and z.
struct Ellipsoid {
    Vec3 middle, half;

    double level(Vec3 p) const {
        const Vec3 d = p - middle;
        return length(Vec3{d.x / half.x, d.y / half.y, d.z / half.z}) - 1;
    }

    // What a plane cuts of it; nothing where it misses.
    Ring section(const Plane& plane, int corners) const {
        const auto shrunk = [&](Vec3 v) { return Vec3{v.x / half.x, v.y / half.y, v.z / half.z}; };
        const Vec3 at = shrunk(plane.origin - middle), u = shrunk(plane.u), v = shrunk(plane.v);
        const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), determinant = uu * vv - uv * uv;
        const Vec2 centre{(uv * dot(at, v) - vv * dot(at, u)) / determinant,
                          (uv * dot(at, u) - uu * dot(at, v)) / determinant};
        const double rest = 1 - dot(at, at) + uu * centre.x * centre.x + 2 * uv * centre.x * centre.y +
                            vv * centre.y * centre.y;
        Ring ring;
        if (!(rest > 0)) return ring;
        for (const Vec2 way : circle({}, 1, corners, 0.1)) {
            const double square = uu * way.x * way.x + 2 * uv * way.x * way.y + vv * way.y * way.y;
            ring.push_back(centre + std::sqrt(rest / square) * way);
        }
        return ring;
    }
};

inline ContourSet sections_of(const Ellipsoid& solid, const std::vector<Plane>& planes, int corners) {
    SetBuilder builder;
    for (const Plane& plane : planes) {
        builder.slice(plane);
        const Ring ring = solid.section(plane, corners);
        if (!ring.empty()) builder.ring(0, ring);
    }
    return builder.set;
}

}  // namespace anatomesh::fixtures
