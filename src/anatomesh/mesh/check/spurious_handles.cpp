#include "anatomesh/mesh/check/spurious_handles.h"

#include <algorithm>

namespace anatomesh {

std::vector<SmallHandles> spurious_handles(std::span<const Vec3> points, std::span<const Triangle> surface,
                                           std::uint32_t structure, const ContourVertices& drawn,
                                           double reach_mm) {
    std::vector<SmallHandles> parts = small_handles(points, surface, reach_mm);
    for (SmallHandles& part : parts) {
        const auto lies_within = [&](const Contour& contour) {
            const auto own = drawn.vertices.subspan(contour.first_point, contour.point_count);
            return contour.structure == structure &&
                   std::all_of(own.begin(), own.end(), [&](std::uint32_t v) {
                       return std::binary_search(part.vertices.begin(), part.vertices.end(), v);
                   });
        };
        const auto told = static_cast<std::uint32_t>(
            std::count_if(drawn.contours.begin(), drawn.contours.end(), lies_within));
        part.handles -= std::min(part.handles, told);
    }
    std::erase_if(parts, [](const SmallHandles& part) { return part.handles == 0; });
    return parts;
}

}  // namespace anatomesh
