#include "anatomesh/contour/chosen_slices.h"

#include <utility>

namespace anatomesh {

ContourSet chosen_slices(const ContourSet& set, std::span<const std::uint32_t> slices) {
    ContourSet part = set;
    part.slices.clear();
    part.contours.clear();
    part.points.clear();
    for (const std::uint32_t s : slices) {
        Slice slice = set.slices[s];
        slice.first_contour = static_cast<std::uint32_t>(part.contours.size());
        for (Contour contour : set.contours_of(set.slices[s])) {
            const auto points = set.points_of(contour);
            contour.slice = static_cast<std::uint32_t>(part.slices.size());
            contour.first_point = static_cast<std::uint32_t>(part.points.size());
            part.points.insert(part.points.end(), points.begin(), points.end());
            part.contours.push_back(contour);
        }
        part.slices.push_back(std::move(slice));
    }
    return part;
}

}  // namespace anatomesh
