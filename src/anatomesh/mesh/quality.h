// Shape measures of tetrahedra. Lengths in mm, angles in degrees.
#pragma once

#include <array>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Circumradius / shortest edge; 0.612 for the regular one, infinity for a flat one.
double radius_edge_ratio(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// The six dihedral angles at the edges cell_edges (in that order).
std::array<double, 6> dihedral_angles(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// Signed volume, positive for positively oriented cells.
double signed_volume(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

Vec3 circumcenter(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

}  // namespace anatomesh
