// The predicates of predicates.h by exact arithmetic alone, for the few signs that rounded arithmetic leaves open.
//
// Guarantees: exact for all finite doubles. Expansions decide coordinates whose magnitudes are zero or in [2^-140, 2^190];
// these are sums of doubles that do not overlap (Shewchuk, Discrete Comput. Geom. 18, 1997). Products of other
// coordinates would leave the range of doubles; whole numbers of any length decide them, some hundred times slower.
// Differences that doubles hold exactly keep the expansions short, so points on a grid take some ten nanoseconds a term.
#pragma once

#include "anatomesh/geom/vec.h"

namespace anatomesh::exact {

int orient2d(Vec2 a, Vec2 b, Vec2 c);
int orient3d(Vec3 a, Vec3 b, Vec3 c, Vec3 d);
int in_sphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Vec3 e);

}  // namespace anatomesh::exact
