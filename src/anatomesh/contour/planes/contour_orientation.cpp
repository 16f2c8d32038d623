#include "anatomesh/contour/planes/contour_orientation.h"

#include <algorithm>

#include "anatomesh/contour/planes/plane_fit.h"

namespace anatomesh {

double PlaneTolerance::off_plane_mm() const {
    return std::max(plane_mm, fitted_share * rounding_mm);
}

void Orientation::add(std::span<const Vec3> members, bool shows_plane) {
    (shows_plane ? scatter : scatter_off).add(scatter_of(members));
    (shows_plane ? points : points_off) += members.size();
}

void Orientation::refine() {
    if (fixed) return;
    // Where points off their planes are many, all together show the plane.
    if (4 * points_off > points + points_off) scatter.add(scatter_off);
    normal = least_direction(scatter);
}

Orientation fixed_orientation(Vec3 normal) {
    Orientation orientation;
    orientation.normal = normal;
    orientation.fixed = true;
    return orientation;
}

OrientationFit fitted_orientation(std::span<const Vec3> points) {
    Orientation orientation;
    orientation.normal = least_direction(scatter_of(points));
    return {orientation, fit_along(points, orientation.normal).deviation};
}

std::optional<OrientationFit> clean_orientation(std::span<const Vec3> points,
                                                const PlaneTolerance& tolerance) {
    const OrientationFit own = fitted_orientation(points);
    for (const int axis : axial_first) {
        const double deviation = fit_along(points, coordinate_axes[axis]).deviation;
        if (deviation <= tolerance.rounding_mm ||
            (deviation <= tolerance.plane_mm && !is_far_better(own, deviation, points.size(), tolerance)))
            return OrientationFit{fixed_orientation(coordinate_axes[axis]), deviation};
    }
    if (own.deviation > tolerance.off_plane_mm()) return std::nullopt;
    return own;
}

OrientationFit damaged_orientation(std::span<const Vec3> points) {
    const int axis = axis_at_one_coordinate(points, std::numeric_limits<double>::infinity());
    if (axis < 0) return fitted_orientation(points);
    return {fixed_orientation(coordinate_axes[axis]), fit_along(points, coordinate_axes[axis]).deviation};
}

bool is_far_better(const OrientationFit& own, double off_mm, std::size_t points,
                   const PlaneTolerance& tolerance) {
    return points >= least_points_of_a_plane &&
           own.deviation <=
               std::max(0.1 * off_mm, std::min(0.5 * off_mm, fitted_share * tolerance.rounding_mm));
}

}  // namespace anatomesh
