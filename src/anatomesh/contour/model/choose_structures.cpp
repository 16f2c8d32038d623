#include "anatomesh/contour/model/choose_structures.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace anatomesh {

ContourSet choose_structures(const ContourSet& set, std::span<const std::uint32_t> chosen) {
    ContourSet part = set;
    part.structures.clear();
    part.contours.clear();
    part.points.clear();
    for (const std::uint32_t structure : chosen) part.structures.push_back(set.structures[structure]);
    for (Slice& slice : part.slices) {
        const auto all = set.contours_of(slice);
        slice.first_contour = static_cast<std::uint32_t>(part.contours.size());
        for (std::uint32_t number = 0; number < chosen.size(); ++number) {
            for (Contour contour : all) {
                if (contour.structure != chosen[number]) continue;
                const auto points = set.points_of(contour);
                contour.structure = number;
                contour.first_point = static_cast<std::uint32_t>(part.points.size());
                part.points.insert(part.points.end(), points.begin(), points.end());
                part.contours.push_back(contour);
            }
        }
        slice.contour_count = static_cast<std::uint32_t>(part.contours.size()) - slice.first_contour;
    }
    return part;
}

RawContours choose_structures(const RawContours& raw, std::span<const std::uint32_t> chosen) {
    constexpr std::uint32_t none = 0xFFFFFFFFu;  // Marks no structure. [index; largest number; D]
    std::vector<std::uint32_t> new_index(raw.structures.size(), none);
    RawContours part = raw;
    part.structures.clear();
    part.contours.clear();
    for (const std::uint32_t index : chosen) {
        new_index[index] = static_cast<std::uint32_t>(part.structures.size());
        part.structures.push_back(raw.structures[index]);
    }
    for (RawContour contour : raw.contours) {
        if (new_index[contour.structure] == none) continue;
        contour.structure = new_index[contour.structure];
        part.contours.push_back(std::move(contour));
    }
    return part;
}

}  // namespace anatomesh
