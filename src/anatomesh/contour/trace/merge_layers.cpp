#include "anatomesh/contour/trace/merge_layers.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace anatomesh {

ContourSet merge_layers(std::vector<ContourSet> layers) {
    if (layers.size() == 1) return std::move(layers[0]);
    ContourSet all;
    all.frame = layers[0].frame;
    all.drawn = layers[0].drawn;
    all.pixel_mm = layers[0].pixel_mm;
    all.source = layers[0].source;
    all.exclusive = false;
    all.complete = layers[0].complete;
    all.slice_thickness_mm = layers[0].slice_thickness_mm;

    struct From {
        std::uint32_t layer, index;
    };
    std::vector<From> structures, slices;
    for (std::uint32_t l = 0; l < layers.size(); ++l) {
        for (std::uint32_t s = 0; s < layers[l].structures.size(); ++s) structures.push_back({l, s});
        for (std::uint32_t s = 0; s < layers[l].slices.size(); ++s) slices.push_back({l, s});
    }
    const auto structure_at = [&](From from) -> const Structure& {
        return layers[from.layer].structures[from.index];
    };
    std::stable_sort(structures.begin(), structures.end(),
                     [&](From a, From b) { return structure_at(a).number < structure_at(b).number; });
    std::vector<std::vector<std::uint32_t>> new_index(layers.size());
    for (std::uint32_t l = 0; l < layers.size(); ++l) new_index[l].resize(layers[l].structures.size());
    for (const From from : structures) {
        new_index[from.layer][from.index] = static_cast<std::uint32_t>(all.structures.size());
        all.structures.push_back(structure_at(from));
    }

    const auto slice_at = [&](From from) -> const Slice& { return layers[from.layer].slices[from.index]; };
    const Vec3 normal = layers[0].slices[0].plane.normal;
    const auto height = [&](From from) { return dot(slice_at(from).plane.origin, normal); };
    std::stable_sort(slices.begin(), slices.end(), [&](From a, From b) { return height(a) < height(b); });
    struct Placed {
        std::uint32_t structure, layer, index;
        Vec3 first;
    };
    for (std::size_t begin = 0; begin < slices.size();) {
        std::size_t end = begin + 1;
        while (end < slices.size() && height(slices[end]) - height(slices[begin]) < 1e-6) ++end;
        std::vector<Placed> contours;
        for (std::size_t s = begin; s < end; ++s) {
            const Slice& slice = slice_at(slices[s]);
            const ContourSet& layer = layers[slices[s].layer];
            for (std::uint32_t c = slice.first_contour; c < slice.first_contour + slice.contour_count; ++c)
                contours.push_back({new_index[slices[s].layer][layer.contours[c].structure], slices[s].layer,
                                    c, layer.points[layer.contours[c].first_point]});
        }
        std::stable_sort(contours.begin(), contours.end(), [](const Placed& a, const Placed& b) {
            return a.structure != b.structure ? a.structure < b.structure
                                              : lexicographic_less(a.first, b.first);
        });
        Slice slice = slice_at(slices[begin]);
        slice.first_contour = static_cast<std::uint32_t>(all.contours.size());
        slice.contour_count = static_cast<std::uint32_t>(contours.size());
        for (const Placed& placed : contours) {
            const ContourSet& layer = layers[placed.layer];
            Contour contour = layer.contours[placed.index];
            const auto points = layer.points_of(contour);
            contour.structure = placed.structure;
            contour.slice = static_cast<std::uint32_t>(all.slices.size());
            contour.first_point = static_cast<std::uint32_t>(all.points.size());
            all.points.insert(all.points.end(), points.begin(), points.end());
            all.contours.push_back(contour);
        }
        all.slices.push_back(std::move(slice));
        begin = end;
    }
    return all;
}

}  // namespace anatomesh
