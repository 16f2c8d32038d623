// Which structures a writer writes: those with contours, by number.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Indices into set.structures.
inline std::vector<std::uint32_t> drawn_structures(const ContourSet& set) {
    std::vector<bool> drawn(set.structures.size(), false);
    for (const Contour& contour : set.contours) drawn[contour.structure] = true;
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i < set.structures.size(); ++i)
        if (drawn[i]) indices.push_back(i);
    std::sort(indices.begin(), indices.end(), [&](std::uint32_t a, std::uint32_t b) {
        return set.structures[a].number < set.structures[b].number;
    });
    return indices;
}

}  // namespace anatomesh
