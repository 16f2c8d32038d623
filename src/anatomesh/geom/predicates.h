// Exact geometric predicates: the sign is that of exact arithmetic on the given doubles, always.
//
// Requires: finite coordinates; exact for all of them, however large or small. A ladder: rounded arithmetic
// with a proved bound of its error decides nearly always, predicates_exact.h the rest.
#pragma once

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Positive if a, b, c run counter-clockwise, negative if clockwise, 0 if collinear.
int orient2d(Vec2 a, Vec2 b, Vec2 c);

// Positive if the cell (a, b, c, d) is positively oriented: dot(cross(b - a, c - a), d - a) > 0.
int orient3d(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// Positive if e lies inside the sphere through the positively oriented cell (a, b, c, d), 0 if on it.
int in_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e);

// Same sign, where 0 is decided as if every point were moved off the sphere by an infinitely small amount of
// its own, the more the later it comes in lexicographic order: never 0 for five distinct points of which (a,
// b, c, d) is a positive cell. The cells whose perturbed spheres hold no point are the one Delaunay
// tetrahedralization of the perturbed points; none of them is flat (Devillers and Teillaud, Comput. Geom. 44,
// 2011). A point e equal to one of the others is outside.
int in_perturbed_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e);

// What rounding can do to the two determinants when all differences of coordinates are at most `extent` in
// magnitude: a determinant that orient3d or in_sphere compute by at most as many roundings from differences
// of coordinates has the right sign when its magnitude is above the bound. Infinite where the range of
// doubles gives no bound.
struct RoundingBounds {
    double orient3d, in_sphere;
    double in_sphere_underflow;  // the part of in_sphere that is due to underflow
};
RoundingBounds rounding_bounds(Vec3 extent);

// in_sphere's part due to rounding: this times the product of the extents and the sum of their squares.
inline constexpr double in_sphere_rounding = 409 * 0x1p-53;

}  // namespace anatomesh
