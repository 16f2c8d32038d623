// group_planes: on which plane each contour lies, and which contours share a slice.
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

// Declared planes are taken as they are: contours of one share a slice. Otherwise: three quarters of a
// contour's points at one x, y or z say an axis-parallel plane. Where some contours lie otherwise, those that
// lie on one plane together as well as each of them does alone (within its own deviation and the rounding of
// the coordinates) are put together first, the largest first, and have the least-squares plane of all their
// points; planes that agree within the tolerance get one normal, refined over all of them, so that a stack
// that is tilted has one, but not planes that cross within their contours. Small or damaged contours join the
// orientation they fit. Guarantees: every slice's plane is make_plane(origin, normal) with the origin the
// foot of (0, 0, 0), so that an axial slice has in-plane coordinates equal to x and y; the normal's largest
// component is positive (ties: z, then y); parallel planes share a slice when they lie within
// group_tolerance_mm and that is little beside the stack itself: 2 % of its largest gap, or of two planes
// alone 1e-3 of the contours' extent. A stack of finer slices keeps them all. Planes that were not declared,
// further apart than that but by no more than plane_repair_mm, are one slice where their contours show it
// (near_planes.h). Where contours lie further than the tolerance off their planes, all of a stack show its
// normal together, and an axis is taken that fits as well. The result depends on the order
// of contours only through rounding in the refined normal: give them in a canonical order. Complexity:
// O(points x orientations + contours x slices), and the points of a slice once more for each of its contours.
PlaneGroups group_planes(std::span<const ContourToPlace> contours, std::span<const Plane> declared,
                         const PlaneGroupingOptions& options);

// The index (0, 1, 2) of the axis that the normal lies along exactly, or -1.
int axis_of(const Plane& plane);

}  // namespace anatomesh
