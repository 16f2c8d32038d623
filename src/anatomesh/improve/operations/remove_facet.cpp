#include <array>

#include "anatomesh/improve/operations/operations.h"

namespace anatomesh {

bool remove_facet(Workbench& bench, std::uint32_t cell, int facet) {
    const std::uint32_t beyond = bench.mesh.neighbor(cell, facet);
    if (beyond == no_cell || bench.mesh.region(beyond) != bench.mesh.region(cell)) return false;
    const Cell &near = bench.mesh.cell(cell), &far = bench.mesh.cell(beyond);
    const auto& f = facet_vertices[facet];
    const std::uint32_t below = near[facet];
    std::uint32_t above = no_cell;
    for (int i = 0; i < 4; ++i) {
        if (bench.mesh.neighbor(beyond, i) == cell) above = far[i];
    }
    const std::array<std::uint32_t, 2> removed{cell, beyond};
    const Bar bar = bench.bar_of(removed);
    const double needed = bench.needed_sine(bar);
    // Seen from `above` the facet runs counter-clockwise.
    std::array<Cell, 3> added;
    for (std::size_t n = 0; n < 3; ++n) {
        added[n] = {below, above, near[f[n]], near[f[(n + 1) % 3]]};
        if (bench.value(added[n], bench.mesh.region(cell), bar) < needed) return false;
    }
    const Region region = bench.mesh.region(cell);
    const std::array<Region, 3> regions{region, region, region};
    if (!bench.commit(removed, added, regions)) return false;
    bench.count(&DihedralStats::facets_removed);
    return true;
}

}  // namespace anatomesh
