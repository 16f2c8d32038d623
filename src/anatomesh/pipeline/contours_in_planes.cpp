#include "anatomesh/pipeline/contours_in_planes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/improve/reroute/routed_contours.h"

namespace anatomesh {

ContourSet contours_in_planes(const Model& model, double tolerance_mm) {
    const ContourSet& kept = model.drawn;
    std::vector<RoutedContour> in_planes;
    for (const RoutedContour& contour : model.routed) {
        const Plane& plane = kept.slices[kept.contours[contour.contour].slice].plane;
        if (std::ranges::all_of(contour.vertices, [&](std::uint32_t v) {
                return std::abs(plane.signed_distance(model.mesh.points[v])) <= tolerance_mm;
            }))
            in_planes.push_back(contour);
    }
    const std::vector<std::uint32_t> vertex_of(kept.points.size(), 0);
    const auto written = [&] {
        return route_contours(kept, vertex_of, in_planes, model.mesh.points).contours;
    };
    ContourSet contours = written();
    // One that is led may cross another one of its slice that is as drawn again.
    const std::size_t before = in_planes.size();
    std::erase_if(in_planes, [&](const RoutedContour& contour) {
        const Slice& slice = contours.slices[kept.contours[contour.contour].slice];
        return !slice_faults(plane_rings(contours, slice), contours.exclusive).empty();
    });
    return in_planes.size() == before ? contours : written();
}

}  // namespace anatomesh
