// Orientation: a normal that contours share; and which one a single contour shows.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "anatomesh/geom/point_scatter.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// How far points may lie off a plane that they show.
struct PlaneTolerance {
    double plane_mm = 0.05;  // PlaneGroupingOptions::plane_tolerance_mm
    double repair_mm = 1.0;  // PlaneGroupingOptions::plane_repair_mm
    double rounding_mm = 0;  // coordinate_rounding() of all contours

    // Returns how far off a plane points still show it, rounding included.
    double off_plane_mm() const;
};

// The normal of some contours. Their points are pooled, so that it can be refined over all of them.
struct Orientation {
    Vec3 normal;
    bool fixed = false;  // an axis or a declared normal: not to be refined
    // Of the members: those that lie on planes across the normal, and the others.
    Scatter scatter, scatter_off;
    std::size_t points = 0, points_off = 0;

    void add(std::span<const Vec3> members, bool shows_plane);
    // Takes the least-squares normal of all members. Those off their planes are left out where they are few.
    void refine();
};

Orientation fixed_orientation(Vec3 normal);

// What one contour shows, and how far its points lie off that plane.
struct OrientationFit {
    Orientation orientation;
    double deviation = std::numeric_limits<double>::infinity();
};

// Each requires points and is O(points).

// Returns the least-squares plane of the points, however far they lie off it.
OrientationFit fitted_orientation(std::span<const Vec3> points);

// Returns the orientation of points that lie on one plane within the tolerance, an axis before others; else nothing.
std::optional<OrientationFit> clean_orientation(std::span<const Vec3> points,
                                                const PlaneTolerance& tolerance);

// Returns the best guess for a contour with points off its plane: an axis where most points show one.
OrientationFit damaged_orientation(std::span<const Vec3> points);

// Returns whether points fit a plane of their own far better than one that they lie `off_mm` off. A few points always
// lie near some plane, so they never do.
bool is_far_better(const OrientationFit& own, double off_mm, std::size_t points,
                   const PlaneTolerance& tolerance);

}  // namespace anatomesh
