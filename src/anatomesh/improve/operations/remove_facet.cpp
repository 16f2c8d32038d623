#include <array>

#include "anatomesh/improve/operations/operations.h"

namespace anatomesh {

bool remove_facet(EditContext& edit, std::uint32_t cell, int facet) {
    const std::uint32_t beyond = edit.mesh.neighbor(cell, facet);
    if (beyond == no_cell || edit.mesh.region(beyond) != edit.mesh.region(cell)) return false;
    const Cell &near = edit.mesh.cell(cell), &far = edit.mesh.cell(beyond);
    const auto& f = facet_vertices[facet];
    const std::uint32_t below = near[facet];
    std::uint32_t above = no_cell;
    for (int i = 0; i < 4; ++i) {
        if (edit.mesh.neighbor(beyond, i) == cell) above = far[i];
    }
    const std::array<std::uint32_t, 2> removed{cell, beyond};
    const QualityThreshold threshold = edit.threshold_of(removed);
    const double needed = edit.rule.needed_sine(threshold);
    // Seen from `above` the facet runs counter-clockwise.
    std::array<Cell, 3> added;
    for (std::size_t n = 0; n < 3; ++n) {
        added[n] = {below, above, near[f[n]], near[f[(n + 1) % 3]]};
        if (edit.value(added[n], edit.mesh.region(cell), threshold) < needed) return false;
    }
    const Region region = edit.mesh.region(cell);
    const std::array<Region, 3> regions{region, region, region};
    if (!edit.commit(removed, added, regions)) return false;
    edit.count(&OperationCounts::facets_removed);
    return true;
}

}  // namespace anatomesh
