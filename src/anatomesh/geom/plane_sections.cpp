#include "anatomesh/geom/plane_sections.h"

#include <cstddef>

namespace anatomesh {

PlaneSection section_at(const std::array<Vec3, 4>& corners, const std::array<double, 4>& heights) {
    PlaneSection section;
    std::array<Vec3, 4> outline;
    std::size_t count = 0, above = 0, apex = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        above += heights[i] > 0;
        if (heights[i] == 0) {
            outline[count++] = corners[i];
        } else {
            apex = i;
        }
    }
    if (count == 3) {
        section.facet = static_cast<int>(apex);
    } else if (above == 0 || above + count == 4) {
        return section;
    }
    // After corners in the plane those on edges: from each vertex below to those above, there and back.
    bool back = false;
    for (std::size_t i = 0; i < 4 && section.facet == PlaneSection::no_facet; ++i) {
        if (heights[i] >= 0) continue;
        for (std::size_t n = 0; n < 4; ++n) {
            const std::size_t j = back ? 3 - n : n;
            if (heights[j] <= 0) continue;
            outline[count++] =
                corners[i] + heights[i] / (heights[i] - heights[j]) * (corners[j] - corners[i]);
        }
        back = !back;
    }
    for (std::size_t n = 0; n < count; ++n)
        section.middle = section.middle + (1 / static_cast<double>(count)) * outline[n];
    section.area = triangle_area(outline[0], outline[1], outline[2]);
    if (count == 4) section.area += triangle_area(outline[0], outline[2], outline[3]);
    return section;
}

}  // namespace anatomesh
