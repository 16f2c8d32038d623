// The last steps of the predicates' ladder: the same signs as predicates.h, by exact arithmetic alone.
//
// Guarantees: exact for all finite doubles. Coordinates whose magnitudes are zero or in [2^-140, 2^190] are
// decided by expansions, sums of doubles that do not overlap (Shewchuk, Discrete Comput. Geom. 18, 1997);
// others, whose products would leave the range of doubles, by whole numbers of any length, some hundred times
// slower. Differences that doubles hold exactly keep the expansions short: points on a grid are decided in
// some ten nanoseconds a term.
#pragma once

#include "anatomesh/geom/vec.h"

namespace anatomesh::exact {

int orient2d(Vec2 a, Vec2 b, Vec2 c);
int orient3d(Vec3 a, Vec3 b, Vec3 c, Vec3 d);
int in_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e);

}  // namespace anatomesh::exact
