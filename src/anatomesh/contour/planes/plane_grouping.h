// group_planes: the plane of each contour, and the contours that share a slice.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

struct PlaneGroupingOptions {
    double plane_tolerance_mm = 0.05;  // points this far off their plane still show what plane it is
    double plane_repair_mm = 1.0;      // a contour further off than this from every known plane gets its own
    double group_tolerance_mm = 0.01;  // planes closer than this at their contours' extent may be one slice

    bool operator==(const PlaneGroupingOptions&) const = default;
};

struct ContourToPlace {
    std::span<const Vec3> points;  // not empty
    std::int32_t plane = -1;       // index into the declared planes; -1: to be fitted
    std::uint32_t structure = 0;
};

struct PlaneGroups {
    std::vector<Plane> slices;            // by normal, then by position along it
    std::vector<double> spread_mm;        // per slice: how far apart its contours' own planes lie
    std::vector<std::uint32_t> slice_of;  // per contour
};

// Declared planes are taken as they are, and contours of one share a slice. Other contours are grouped so:
// - Three quarters of a contour's points at one x, y or z show an axis-parallel plane.
// - Where some contours lie otherwise, those that lie on one plane are put together first. They lie on it as well as
//   each of them does alone, within its own deviation and the rounding of the coordinates. The largest come first, and
//   they get the least-squares plane of all their points.
// - Planes that agree within the tolerance get one normal, refined over all of them, so that a tilted stack has one;
//   planes that cross within their contours do not.
// - Small or damaged contours join the orientation that they fit.
// - Where contours lie further than the tolerance off their planes, all of a stack show its normal together, and an
//   axis is taken that fits as well.
// Parallel planes share a slice when they lie within group_tolerance_mm, and this is little beside the stack itself. It is
// little up to 2 % of the largest gap, or, for two planes alone, up to 1e-3 of the contours' extent. So a stack of finer
// slices keeps them all. Planes that were not declared, farther apart but by no more than plane_repair_mm, are one
// slice where their contours show it (near_planes.h).
// Guarantees: every slice's plane is make_plane(origin, normal) with the origin the foot of (0, 0, 0), so an axial slice
// has in-plane coordinates equal to x and y. The normal's largest component is positive (ties: z, then y). The result
// depends on the order of contours only through rounding in the refined normal: give them in a canonical order.
// Complexity: O(points x orientations + contours x slices), and the points of a slice once more for each of its
// contours.
PlaneGroups group_planes(std::span<const ContourToPlace> contours, std::span<const Plane> declared,
                         const PlaneGroupingOptions& options);

// The index (0, 1, 2) of the axis that the normal lies along exactly, or -1.
int axis_of(const Plane& plane);

}  // namespace anatomesh
