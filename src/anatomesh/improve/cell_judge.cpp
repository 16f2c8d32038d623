#include "anatomesh/improve/cell_judge.h"

#include <utility>

#include "anatomesh/mesh/cell_shape.h"

namespace anatomesh {

bool CellJudge::is_good(std::uint32_t c) const {
    if (!bench_.mesh.alive(c) || bench_.mesh.region(c) == 0) return true;
    const Cell& v = bench_.mesh.cell(c);
    const bool crowded = drawn_.are_crowded(v);
    const CellMeasures m = measure_cell(bench_.mesh.point(v[0]), bench_.mesh.point(v[1]),
                                        bench_.mesh.point(v[2]), bench_.mesh.point(v[3]));
    const double most = crowded ? most_crowded_ratio : bench_.options.last_radius_edge;
    return m.least_sine() >= (crowded ? least_crowded_sine : least_sine_) && m.squared_ratio <= most * most;
}

bool CellJudge::is_near(std::uint32_t c) {
    if (!bench_.mesh.alive(c)) return true;
    const Cell& cell = bench_.mesh.cell(c);
    const double most = bench_.options.apex_mm;
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t other = bench_.mesh.neighbor(c, i);
        if (other == no_cell || bench_.mesh.region(other) == bench_.mesh.region(c)) continue;
        bench_.look_between(bench_.mesh.region(c), bench_.mesh.region(other));
        const auto& f = facet_vertices[i];
        if (bench_.facet_distance(bench_.mesh.point(cell[f[0]]), bench_.mesh.point(cell[f[1]]),
                                  bench_.mesh.point(cell[f[2]])) > most)
            return false;
        for (const int k : f) {
            if (!bench_.fixed(cell[k]) && bench_.probe.distance(bench_.mesh.point(cell[k]), most) > most)
                return false;
        }
    }
    return true;
}

std::vector<std::uint32_t> CellJudge::those_above_bound(std::vector<std::uint32_t> cells) const {
    const double most = bench_.options.max_radius_edge;
    std::erase_if(cells, [&](std::uint32_t c) {
        if (!bench_.mesh.alive(c) || bench_.mesh.region(c) == 0) return true;
        const Cell& v = bench_.mesh.cell(c);
        return drawn_.are_crowded(v) ||
               !(squared_radius_edge(bench_.mesh.point(v[0]), bench_.mesh.point(v[1]),
                                     bench_.mesh.point(v[2]), bench_.mesh.point(v[3])) > most * most);
    });
    return cells;
}

}  // namespace anatomesh
