#include "anatomesh/field/warnings/thin_structures.h"

#include <string>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/field/slice/slice_regions.h"

namespace anatomesh {

std::vector<double> mean_thicknesses(const ContourSet& set) {
    std::vector<double> area(set.structures.size(), 0), length_of(set.structures.size(), 0);
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        for (const SliceRegion& region : slice_regions(set, s, set.slices[s].plane)) {
            for (const Edge2& edge : region.edges) {
                area[region.structure] +=
                    0.5 * cross(edge.a - region.edges.front().a, edge.b - region.edges.front().a);
                length_of[region.structure] += length(edge.b - edge.a);
            }
        }
    }
    std::vector<double> thickness(area.size(), 0);
    for (std::size_t s = 0; s < area.size(); ++s) {
        if (length_of[s] > 0) thickness[s] = 2 * area[s] / length_of[s];
    }
    return thickness;
}

void warn_about_thin_structures(const ContourSet& set, double spacing, RunContext& context) {
    const std::vector<double> thicknesses = mean_thicknesses(set);
    for (std::size_t s = 0; s < thicknesses.size(); ++s) {
        const double thickness = thicknesses[s];
        if (!(thickness > 0) || thickness >= spacing) continue;
        const Structure& structure = set.structures[s];
        context.warn(
            {"W-FLD-007",
             "the structure is thinner than the distance between its planes, which cross or nearly cross",
             {set.source, "", structure.name.empty() ? std::to_string(structure.number) : structure.name, "",
              brief(thickness) + " mm thick on average, planes " + brief(spacing) + " mm apart"},
             "it may have holes or gaps between the planes; draw it on more planes, or on parallel ones"});
    }
}

}  // namespace anatomesh
