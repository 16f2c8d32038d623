#include "anatomesh/uncertainty/evidence.h"

#include <algorithm>

namespace anatomesh {

namespace {

SurfaceMesh segments_of(const ContourSet& set, std::uint32_t structure) {
    SurfaceMesh segments;
    for (const Contour& contour : set.contours) {
        if (contour.structure != structure) continue;
        const auto first = static_cast<std::uint32_t>(segments.points.size());
        const auto points = set.points_of(contour);
        segments.points.insert(segments.points.end(), points.begin(), points.end());
        for (std::uint32_t n = 0; n < contour.point_count; ++n) {
            const std::uint32_t next = first + (n + 1) % contour.point_count;
            segments.triangles.push_back({first + n, next, next});
        }
    }
    return segments;
}

}  // namespace

ContourEvidence::ContourEvidence(const ContourSet& set, std::uint32_t structure)
    : segments_(segments_of(set, structure)), nearest_(segments_) {}

double ContourEvidence::distance(Vec3 p, double reach) const {
    return empty() ? reach : std::min(reach, nearest_.distance(p));
}

}  // namespace anatomesh
