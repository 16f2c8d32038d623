#include "anatomesh/measure/volume.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh/slices/coverage/few_slices.h"

namespace anatomesh {

namespace {

// Signed area of a contour about the slice's normal.
double signed_area(std::span<const Vec3> polygon, Vec3 normal) {
    Vec3 sum;
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
        sum += cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
    }
    return dot(sum, normal) / 2;
}

// The thickness that each slice stands for among those that count; 0 for the others. Beyond a slice that draws the
// structure one that does not is no further away than the slice on the other side, unless slices say all.
// Requires: two that count.
std::vector<double> slice_thickness(const ContourSet& set, const std::vector<bool>& counts,
                                    const std::vector<bool>& draws) {
    const Vec3 normal = set.slices.front().plane.normal;
    std::vector<double> position;
    for (const Slice& slice : set.slices) position.push_back(dot(slice.plane.origin, normal));
    std::vector<std::size_t> order;
    for (std::size_t s = 0; s < position.size(); ++s) {
        if (counts[s]) order.push_back(s);
    }
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return position[a] < position[b]; });
    const auto gap = [&](std::size_t i) { return position[order[i + 1]] - position[order[i]]; };
    std::vector<double> thickness(position.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        double before = i > 0 ? gap(i - 1) : gap(i);
        double after = i + 1 < order.size() ? gap(i) : gap(i - 1);
        if (!says_all(set) && i > 0 && !draws[order[i - 1]]) before = std::min(before, after);
        if (!says_all(set) && i + 1 < order.size() && !draws[order[i + 1]]) after = std::min(after, before);
        thickness[order[i]] = (before + after) / 2;
    }
    return thickness;
}

}  // namespace

std::vector<double> mesh_volumes(const TetMesh& mesh, const RegionTable& regions,
                                 std::size_t structure_count) {
    std::vector<double> of_region(regions.members.size(), 0.0);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const auto& [i, j, k, l] = mesh.cells[c];
        of_region[mesh.regions[c]] +=
            signed_volume(mesh.points[i], mesh.points[j], mesh.points[k], mesh.points[l]);
    }
    std::vector<double> of_structure(structure_count, 0.0);
    for (std::size_t r = 0; r < of_region.size(); ++r) {
        for (const std::uint32_t s : regions.members[r]) of_structure[s] += of_region[r];
    }
    return of_structure;
}

std::vector<double> slice_volumes(const ContourSet& set, const SliceCoverage& coverage) {
    if (set.slices.size() < 2 || !all_parallel(set, parallel_tolerance_mm)) return {};
    // By structure: many are drawn on the same slices.
    std::map<std::pair<std::vector<bool>, std::vector<bool>>, std::vector<double>> thickness_of;
    std::vector<const std::vector<double>*> thickness;
    const std::vector<bool> all(set.slices.size(), true);
    for (std::uint32_t i = 0; i < set.structures.size(); ++i) {
        std::vector<bool> counts(set.slices.size()), draws(set.slices.size());
        for (std::uint32_t k = 0; k < counts.size(); ++k) {
            counts[k] = coverage.is_certain(k, i);
            draws[k] = coverage.is_drawn(k, i);
        }
        if (std::count(counts.begin(), counts.end(), true) < 2) counts = all;
        const auto [found, is_new] = thickness_of.try_emplace({std::move(counts), std::move(draws)});
        if (is_new) found->second = slice_thickness(set, found->first.first, found->first.second);
        thickness.push_back(&found->second);
    }
    std::vector<double> of_few(set.structures.size(), 0.0);
    for (const FewSlices& few :
         structures_on_few_slices(set, parallel_intervals(set, set.slices.front().plane), 0))
        of_few[few.structure] = few.mm;
    std::vector<double> volumes(set.structures.size(), 0.0);
    std::vector<double> areas(set.structures.size());
    for (std::size_t s = 0; s < set.slices.size(); ++s) {
        const Slice& slice = set.slices[s];
        std::fill(areas.begin(), areas.end(), 0.0);
        for (const Contour& contour : set.contours_of(slice)) {
            areas[contour.structure] += signed_area(set.points_of(contour), slice.plane.normal);
        }
        for (std::size_t i = 0; i < areas.size(); ++i)
            volumes[i] += std::abs(areas[i]) *
                          (of_few[i] > 0 ? std::min(of_few[i], (*thickness[i])[s]) : (*thickness[i])[s]);
    }
    return volumes;
}

}  // namespace anatomesh
