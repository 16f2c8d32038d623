#include <algorithm>
#include <array>

#include "anatomesh/improve/operations.h"

namespace anatomesh {

namespace {

// The facets of a cell that lie between it and the outside.
struct OuterFacets {
    int count = 0;
    std::array<bool, 4> outer{};
};

// False when a third region, or nothing, lies beyond a facet.
bool outer_facets(const Workbench& bench, std::uint32_t cell, OuterFacets& facets) {
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t n = bench.mesh.neighbor(cell, i);
        if (n == no_cell) return false;
        facets.outer[i] = bench.mesh.region(n) == 0;
        facets.count += facets.outer[i];
        if (!facets.outer[i] && bench.mesh.region(n) != bench.mesh.region(cell)) return false;
    }
    return true;
}

// Whether a disc of the surface is replaced by a disc: what the cell's other facets bring to the surface,
// apart from its rim, must not lie on an interface yet; and what goes must not be fixed.
bool keeps_surface(Workbench& bench, std::uint32_t cell, const OuterFacets& facets) {
    const Cell& c = bench.mesh.cell(cell);
    if (facets.count == 1) {
        const int apex = static_cast<int>(std::find(facets.outer.begin(), facets.outer.end(), true) -
                                          facets.outer.begin());
        return !bench.mesh.vertex_on_interface(c[apex]);
    }
    if (facets.count == 2) {
        // The facets opposite i and j share the edge of the other two vertices; the edge ij comes to the
        // surface.
        for (int e = 0; e < 6; ++e) {
            const auto [i, j] = cell_edges[e];
            if (!facets.outer[i] || !facets.outer[j]) continue;
            const auto [k, l] = across_edges[e];
            return !bench.fixed_edge(c[k], c[l]) && !bench.mesh.edge_on_interface(cell, e);
        }
    }
    return false;
}

}  // namespace

bool peel_cell(Workbench& bench, std::uint32_t cell) {
    OuterFacets facets;
    if (!outer_facets(bench, cell, facets) || !keeps_surface(bench, cell, facets)) return false;
    const Cell c = bench.mesh.cell(cell);
    double before = 0;
    for (const bool outer : {true, false}) {
        for (int i = 0; i < 4; ++i) {
            if (facets.outer[i] != outer) continue;
            const auto& f = facet_vertices[i];
            if (outer) {
                before = std::max(before,
                                  bench.facet_distance(bench.mesh.point(c[f[0]]), bench.mesh.point(c[f[1]]),
                                                       bench.mesh.point(c[f[2]])));
            } else if (!bench.near_interface(c[f[0]], c[f[1]], c[f[2]], before)) {
                return false;
            }
        }
    }
    bench.mesh.set_region(cell, 0);
    bench.changed.clear();
    ++bench.stats.cells_peeled;
    return true;
}

}  // namespace anatomesh
