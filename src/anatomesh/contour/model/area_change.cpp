#include "anatomesh/contour/model/area_change.h"

#include <cassert>
#include <cmath>

#include "anatomesh/base/number_text.h"

namespace anatomesh {

namespace {

// Of the drawn area; simplification within a fraction of a pixel stays well below it. [1; 0 to 1; C W-CON-024]
constexpr double most_change = 0.05;

}  // namespace

double area_in_plane(std::span<const Vec3> polygon, Vec3 normal) {
    Vec3 sum{};
    for (std::size_t n = 1; n + 1 < polygon.size(); ++n) {
        sum = sum + cross(polygon[n] - polygon[0], polygon[n + 1] - polygon[0]);
    }
    return dot(sum, normal) / 2;
}

AreaChange area_change(std::uint32_t structure, std::span<const Vec3> before, std::span<const Vec3> after,
                       Vec3 normal) {
    const double area = area_in_plane(before, normal);
    return {structure, area, std::abs(area_in_plane(after, normal) - area)};
}

void warn_of_area_changes(std::span<const AreaChange> changes, const std::vector<Structure>& structures,
                          const std::string& source, RunContext& context) {
    std::vector<AreaChange> sums(structures.size());
    for (const AreaChange& change : changes) {
        assert(change.structure < sums.size());
        sums[change.structure].area_mm2 += change.area_mm2;
        sums[change.structure].change_mm2 += change.change_mm2;
    }
    for (std::size_t s = 0; s < sums.size(); ++s) {
        if (!(sums[s].change_mm2 > most_change * sums[s].area_mm2)) continue;
        const Structure& structure = structures[s];
        context.warn(
            {"W-CON-024",
             "simplification changes the area of the contours by more than 5 %",
             {source, "", structure.name.empty() ? std::to_string(structure.number) : structure.name, "",
              brief(100 * sums[s].change_mm2 / sums[s].area_mm2) + " %"},
             "the simplified contours were used; a smaller --epsilon keeps them closer to the drawing"});
    }
}

}  // namespace anatomesh
