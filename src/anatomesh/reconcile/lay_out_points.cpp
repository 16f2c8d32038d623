#include "anatomesh/reconcile/lay_out_points.h"

#include <cassert>
#include <cstdint>
#include <utility>

namespace anatomesh {

void lay_out_points(ContourSet& set, std::span<const std::vector<Vec3>> of_contours) {
    assert(of_contours.size() == set.contours.size());
    std::vector<Vec3> points;
    for (std::size_t c = 0; c < of_contours.size(); ++c) {
        set.contours[c].first_point = static_cast<std::uint32_t>(points.size());
        set.contours[c].point_count = static_cast<std::uint32_t>(of_contours[c].size());
        points.insert(points.end(), of_contours[c].begin(), of_contours[c].end());
    }
    set.points = std::move(points);
}

}  // namespace anatomesh
