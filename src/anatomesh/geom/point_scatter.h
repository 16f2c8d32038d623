// The plane that points lie near: their scatter and its least direction.
#pragma once

#include <span>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Symmetric 3 x 3 matrix: the sums of products of coordinates relative to a mean.
struct Scatter {
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

    void add(Vec3 d) {
        xx += d.x * d.x, xy += d.x * d.y, xz += d.x * d.z;
        yy += d.y * d.y, yz += d.y * d.z, zz += d.z * d.z;
    }
    void add(const Scatter& other) {
        xx += other.xx, xy += other.xy, xz += other.xz;
        yy += other.yy, yz += other.yz, zz += other.zz;
    }
    Vec3 times(Vec3 d) const {
        return {xx * d.x + xy * d.y + xz * d.z, xy * d.x + yy * d.y + yz * d.z,
                xz * d.x + yz * d.y + zz * d.z};
    }
};

// Of two opposite normals the one whose largest component is positive.
Vec3 canonical(Vec3 normal);

// Unit eigenvector of the smallest eigenvalue, canonical, by Jacobi rotations (Golub and Van Loan, Matrix
// Computations, section 8.5). O(1).
Vec3 least_direction(const Scatter& scatter);

// Require: points. O(n).
Vec3 mean_of(std::span<const Vec3> points);
Scatter scatter_of(std::span<const Vec3> points);

// Size of the area vector of a closed polygon (Newell).
double vector_area(std::span<const Vec3> points);

}  // namespace anatomesh
