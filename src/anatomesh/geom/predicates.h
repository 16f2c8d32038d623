// Exact geometric predicates: the sign is always that of exact arithmetic on the given doubles.
//
// Requires: finite coordinates, however large or small. Rounded arithmetic with a proved bound of its error decides
// nearly always, and predicates_exact.h decides the rest.
#pragma once

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Positive if a, b, c run counter-clockwise, negative if clockwise, 0 if collinear.
int orient2d(Vec2 a, Vec2 b, Vec2 c);

// Positive if the cell (a, b, c, d) is positively oriented: dot(cross(b - a, c - a), d - a) > 0.
int orient3d(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// Positive if e lies inside the sphere through the positively oriented cell (a, b, c, d), 0 if on it.
int in_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e);

// Returns the sign of in_sphere. A 0 is decided as if every point were moved off the sphere by an infinitely small amount,
// which is larger for points later in lexicographic order. So the result is never 0 for five distinct
// points of which (a, b, c, d) is a positive cell. The cells whose perturbed spheres hold no point are the one Delaunay
// tetrahedralization of the perturbed points, and none of them is flat (Devillers and Teillaud, Comput. Geom. 44, 2011).
// A point e equal to one of the others is outside.
int in_perturbed_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e);

// Bounds of the rounding of the two determinants when all differences of coordinates are at most `extent` in magnitude.
// A determinant that is computed by no more roundings than those of orient3d or in_sphere has the right sign when its
// magnitude is above the bound. A bound is infinite where the range of doubles gives
// none.
struct RoundingBounds {
    double orient3d, in_sphere;
    double in_sphere_underflow;  // the part of in_sphere that is due to underflow
};
RoundingBounds rounding_bounds(Vec3 extent);

// The part of in_sphere that is due to rounding is at most this times the product of the extents and the sum of their
// squares. [1; > 0; D]
inline constexpr double in_sphere_rounding = 409 * 0x1p-53;

}  // namespace anatomesh
