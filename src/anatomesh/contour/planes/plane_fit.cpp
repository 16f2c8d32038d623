#include "anatomesh/contour/planes/plane_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "anatomesh/geom/point_scatter.h"

namespace anatomesh {

namespace {

double lower_median(std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

PlaneFit fit_along(std::span<const Vec3> points, Vec3 normal) {
    std::vector<double> along;
    along.reserve(points.size());
    for (const Vec3& p : points) along.push_back(dot(p, normal));
    const auto [low, high] = std::minmax_element(along.begin(), along.end());
    PlaneFit fit{0, 0, *low, *high};
    fit.offset = lower_median(along);
    for (const double d : along) fit.deviation = std::max(fit.deviation, std::abs(d - fit.offset));
    return fit;
}

int axis_at_one_coordinate(std::span<const Vec3> points, double allowed_mm) {
    for (const int axis : axial_first) {
        const PlaneFit fit = fit_along(points, coordinate_axes[axis]);
        std::size_t same = 0;
        for (const Vec3& p : points) same += dot(p, coordinate_axes[axis]) == fit.offset;
        if (4 * same >= 3 * points.size() && fit.deviation <= allowed_mm) return axis;
    }
    return -1;
}

double noise_off_own_plane(std::span<const Vec3> points) {
    if (points.size() < least_points_of_a_plane) return 0;
    const Scatter scatter = scatter_of(points);
    const Vec3 normal = least_direction(scatter);
    return std::sqrt(std::max(dot(normal, scatter.times(normal)), 0.0) / static_cast<double>(points.size()));
}

double coordinate_rounding(std::span<const ContourToPlace> contours) {
    for (const double step : {0.1, 0.01, 0.001}) {
        const auto is_multiple = [&](double v) {
            return std::abs(v - step * std::round(v / step)) <= 1e-12 * (1 + std::abs(v));
        };
        const bool all = std::all_of(contours.begin(), contours.end(), [&](const ContourToPlace& contour) {
            return contour.plane >= 0 ||
                   std::all_of(contour.points.begin(), contour.points.end(), [&](const Vec3& p) {
                       return is_multiple(p.x) && is_multiple(p.y) && is_multiple(p.z);
                   });
        });
        if (all) return 0.5 * std::sqrt(3.0) * step;
    }
    return 0;
}

}  // namespace anatomesh
