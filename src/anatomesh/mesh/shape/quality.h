// Shape measures of tetrahedra. Lengths in mm, angles in degrees.
#pragma once

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Circumradius / shortest edge; 0.612 for the regular one, infinity for a flat one.
double radius_edge_ratio(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// The smallest and the largest of the six dihedral angles. Of the shape alone: orientation does not matter; a
// flat cell has angles 0 and 180.
struct DihedralRange {
    double smallest = 0, largest = 0;
};
DihedralRange dihedral_range(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// Signed volume, positive for positively oriented cells.
double signed_volume(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// Center of the sphere through the four points; not finite for a flat cell.
Vec3 circumcenter(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

}  // namespace anatomesh
