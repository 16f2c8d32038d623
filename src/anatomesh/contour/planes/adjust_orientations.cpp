#include "anatomesh/contour/planes/adjust_orientations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "anatomesh/contour/planes/plane_fit.h"

namespace anatomesh {

namespace {

// How far the points of an orientation's contours lie off planes across its normal, and across each axis.
struct OffPlanes {
    double own = 0;
    std::array<double, 3> along{};
};

std::vector<OffPlanes> off_planes(std::span<const ContourToPlace> contours,
                                  const ContourOrientations& orientations) {
    std::vector<OffPlanes> off(orientations.all.size());
    for (std::size_t c = 0; c < contours.size(); ++c) {
        const auto o = static_cast<std::size_t>(orientations.of_contour[c]);
        if (orientations.all[o].fixed) continue;
        const std::span<const Vec3> points = contours[c].points;
        off[o].own = std::max(off[o].own, fit_along(points, orientations.all[o].normal).deviation);
        for (const int axis : axial_first)
            off[o].along[axis] =
                std::max(off[o].along[axis], fit_along(points, coordinate_axes[axis]).deviation);
    }
    return off;
}

// A contour along the normal of its orientation, and the plane that it shows itself.
struct ContourExtent {
    std::int32_t orientation = 0;
    double low = 0, high = 0;
    std::size_t contour = 0;
    OrientationFit own;
};

// Marks the contours that overlap another one of their orientation along its normal.
void mark_overlapping(std::vector<ContourExtent>& extents, std::vector<bool>& marked) {
    std::stable_sort(extents.begin(), extents.end(), [](const ContourExtent& p, const ContourExtent& q) {
        return p.orientation != q.orientation ? p.orientation < q.orientation : p.low < q.low;
    });
    const ContourExtent* highest = nullptr;
    for (const ContourExtent& one : extents) {
        const bool is_first = !highest || highest->orientation != one.orientation;
        if (!is_first && one.low < highest->high) marked[highest->contour] = marked[one.contour] = true;
        if (is_first || one.high > highest->high) highest = &one;
    }
}

}  // namespace

void refine_normals(std::span<const ContourToPlace> contours, double plane_tolerance_mm,
                    ContourOrientations& orientations) {
    for (Orientation& orientation : orientations.all) orientation.refine();
    const std::vector<OffPlanes> off = off_planes(contours, orientations);
    for (std::size_t o = 0; o < off.size(); ++o) {
        if (orientations.all[o].fixed || off[o].own <= plane_tolerance_mm) continue;
        for (const int axis : axial_first) {
            if (off[o].along[axis] <= fitted_share * off[o].own)
                orientations.all[o].normal = coordinate_axes[axis];
        }
    }
}

void separate_crossing_planes(std::span<const ContourToPlace> contours, const PlaneTolerance& tolerance,
                              const std::vector<bool>& stays, ContourOrientations& orientations) {
    const double off_plane = tolerance.off_plane_mm();
    std::vector<ContourExtent> extents;
    std::vector<bool> leaves(contours.size(), false);
    for (std::size_t c = 0; c < contours.size(); ++c) {
        const std::span<const Vec3> points = contours[c].points;
        if (contours[c].plane >= 0 || stays[c] || points.size() < least_points_of_a_plane) continue;
        const OrientationFit own = fitted_orientation(points);
        if (own.deviation > off_plane) continue;
        const std::int32_t o = orientations.of_contour[c];
        const PlaneFit fit = fit_along(points, orientations.all[o].normal);
        leaves[c] = fit.deviation > off_plane && is_far_better(own, fit.deviation, points.size(), tolerance);
        // Points that lie no closer to a plane of their own overlap others by noise.
        if (2 * own.deviation > fit.deviation && fit.deviation > tolerance.rounding_mm) continue;
        extents.push_back({o, fit.low, fit.high, c, own});
    }
    mark_overlapping(extents, leaves);
    for (const ContourExtent& one : extents) {
        if (!leaves[one.contour]) continue;
        orientations.of_contour[one.contour] = static_cast<std::int32_t>(orientations.all.size());
        orientations.all.push_back(one.own.orientation);
    }
}

}  // namespace anatomesh
