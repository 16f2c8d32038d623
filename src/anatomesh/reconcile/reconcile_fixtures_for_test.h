// Solids cut by planes anywhere, for the tests of this room: sections that agree exactly, or that are drawn
// apart.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh::crossing_fixtures {

using Ring = std::vector<Vec2>;

// Adds a slice with one ring (counter-clockwise seen along -normal), beginning at its smallest point.
inline void add_slice(ContourSet& set, const Plane& plane, const Ring& ring) {
    if (ring.size() < 3) return;
    const auto slice = static_cast<std::uint32_t>(set.slices.size());
    if (set.structures.empty()) set.structures.push_back({1, "solid", {200, 200, 200}});
    set.slices.push_back({plane, static_cast<std::uint32_t>(set.contours.size()), 1, std::to_string(slice)});
    set.contours.push_back(
        {0, slice, static_cast<std::uint32_t>(set.points.size()), static_cast<std::uint32_t>(ring.size())});
    std::vector<Vec3> points;
    for (const Vec2 q : ring) points.push_back(plane.to_space(q));
    std::rotate(points.begin(),
                std::min_element(points.begin(), points.end(),
                                 [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); }),
                points.end());
    set.points.insert(set.points.end(), points.begin(), points.end());
}

struct HalfSpace {
    Vec3 normal;  // outward
    double offset;
};

// A convex polytope round the origin, of radius about `size`.
inline std::vector<HalfSpace> polytope(double size, int faces, std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<HalfSpace> sides;
    for (int axis = 0; axis < 6; ++axis) {
        const double sign = axis % 2 == 0 ? 1 : -1;
        sides.push_back(
            {{axis / 2 == 0 ? sign : 0, axis / 2 == 1 ? sign : 0, axis / 2 == 2 ? sign : 0}, size});
    }
    for (int i = 0; i < faces; ++i) {
        sides.push_back(
            {normalized({unit(random), unit(random), unit(random)}), size * (1 + 0.2 * unit(random))});
    }
    return sides;
}

// The section of a polytope: a big square clipped by its sides. Exact but for rounding.
inline Ring section(const std::vector<HalfSpace>& sides, const Plane& plane) {
    Ring ring{{-1e3, -1e3}, {1e3, -1e3}, {1e3, 1e3}, {-1e3, 1e3}};
    for (const HalfSpace& side : sides) {
        Ring clipped;
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Vec2 p = ring[i], q = ring[(i + 1) % ring.size()];
            const double hp = dot(side.normal, plane.to_space(p)) - side.offset,
                         hq = dot(side.normal, plane.to_space(q)) - side.offset;
            if (hp <= 0) clipped.push_back(p);
            if ((hp < 0 && hq > 0) || (hp > 0 && hq < 0)) clipped.push_back(p + (hp / (hp - hq)) * (q - p));
        }
        ring = clipped;
    }
    return ring;
}

// Planes in any position through a ball of radius `reach`.
inline std::vector<Plane> random_planes(int count, double reach, std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Plane> planes;
    for (int i = 0; i < count; ++i) {
        const Vec3 normal = normalized({unit(random), unit(random), unit(random)});
        planes.push_back(make_plane((reach * unit(random)) * normal, normal));
    }
    return planes;
}

// Three stacks at right angles to each other, but for `tilt`.
inline std::vector<Plane> three_stacks(double reach, double spacing, double tilt) {
    std::vector<Plane> planes;
    for (const Vec3 normal : {Vec3{tilt, 0, 1}, Vec3{0, 1, tilt}, Vec3{1, -tilt, 0}}) {
        const Vec3 n = normalized(normal);
        for (double h = -reach; h <= reach; h += spacing)
            planes.push_back(make_plane((h + 0.13 * spacing) * n, n));
    }
    return planes;
}

inline std::vector<Plane> rotational_planes(int count) {
    std::vector<Plane> planes;
    for (int k = 0; k < count; ++k) {
        const double angle = std::numbers::pi * k / count;
        planes.push_back(make_plane({0, 0, 0}, {std::cos(angle), std::sin(angle), 0}));
    }
    return planes;
}

inline ContourSet cut(const std::vector<HalfSpace>& sides, const std::vector<Plane>& planes) {
    ContourSet set;
    set.source = "solid";
    for (const Plane& plane : planes) add_slice(set, plane, section(sides, plane));
    return set;
}

// The section of the ball of a radius by a plane, as somebody's hand would draw it: moved, scaled, with noise
// that varies slowly along the contour.
struct Hand {
    double shift = 0, noise = 0;  // mm
    int corners = 120;
};

inline ContourSet drawn_ball(double radius, const std::vector<Plane>& planes, const Hand& hand,
                             std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1);
    ContourSet set;
    set.source = "ball";
    for (const Plane& plane : planes) {
        const double h = plane.signed_distance({0, 0, 0}), r2 = radius * radius - h * h;
        if (r2 < 4) continue;
        const Vec2 shift{hand.shift * unit(random), hand.shift * unit(random)};
        const double a = hand.noise * unit(random), b = hand.noise * unit(random), phase = 3 * unit(random);
        Ring ring;
        for (int i = 0; i < hand.corners; ++i) {
            const double angle = 2 * std::numbers::pi * i / hand.corners + 0.001;
            const double r = std::sqrt(r2) + a * std::cos(3 * angle + phase) + b * std::sin(5 * angle);
            ring.push_back(plane.to_plane({0, 0, 0}) + shift +
                           Vec2{r * std::cos(angle), r * std::sin(angle)});
        }
        add_slice(set, plane, ring);
    }
    return set;
}

}  // namespace anatomesh::crossing_fixtures
