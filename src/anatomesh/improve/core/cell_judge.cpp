#include "anatomesh/improve/core/cell_judge.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

constexpr double most_above_bound = 0.003;  // share of cells inside above the first bound

}  // namespace

bool CellJudge::is_good(std::uint32_t c) const {
    if (!bench_.mesh.alive(c) || bench_.mesh.region(c) == 0) return true;
    const Cell& v = bench_.mesh.cell(c);
    const bool crowded = drawn_.are_crowded(v);
    const CellMeasures m = measure_cell(bench_.mesh.point(v[0]), bench_.mesh.point(v[1]),
                                        bench_.mesh.point(v[2]), bench_.mesh.point(v[3]));
    const double most = crowded ? most_crowded_ratio : bench_.options.last_radius_edge;
    return m.least_sine() >= (crowded ? least_crowded_sine : least_sine_) && m.squared_ratio <= most * most;
}

bool CellJudge::is_near(std::uint32_t c, double most_mm) {
    return !any_distance(c, most_mm, [&](double mm) { return mm > most_mm; });
}

double CellJudge::farthest_of(std::span<const std::uint32_t> cells) {
    double farthest = spike_mm();
    for (const std::uint32_t c : cells) {
        any_distance(c, HUGE_VAL, [&](double mm) {
            farthest = std::max(farthest, mm);
            return false;
        });
    }
    return farthest;
}

template <class Is>
bool CellJudge::any_distance(std::uint32_t c, double reach_mm, const Is& is) {
    if (!bench_.mesh.alive(c)) return false;
    const Cell& cell = bench_.mesh.cell(c);
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t other = bench_.mesh.neighbor(c, i);
        if (other == no_cell || bench_.mesh.region(other) == bench_.mesh.region(c)) continue;
        bench_.look_between(bench_.mesh.region(c), bench_.mesh.region(other));
        const auto& f = facet_vertices[i];
        if (is(bench_.facet_distance(bench_.mesh.point(cell[f[0]]), bench_.mesh.point(cell[f[1]]),
                                     bench_.mesh.point(cell[f[2]]))))
            return true;
        for (const int k : f) {
            if (!bench_.fixed(cell[k]) && is(bench_.probe.distance(bench_.mesh.point(cell[k]), reach_mm)))
                return true;
        }
    }
    return false;
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

ShapesKept::ShapesKept(Workbench& bench, const DrawnSlices& drawn, double least_sine)
    : judge_(bench, drawn, least_sine) {
    std::vector<std::uint32_t> all = bench.mesh.alive_cells();
    const auto inside =
        std::count_if(all.begin(), all.end(), [&](std::uint32_t c) { return bench.mesh.region(c) != 0; });
    most_above_ = static_cast<std::size_t>(most_above_bound * static_cast<double>(inside));
    above_bound_ = judge_.those_above_bound(std::move(all));
}

bool ShapesKept::allow(std::span<const std::uint32_t> changed, double most_mm) {
    if (!std::all_of(changed.begin(), changed.end(),
                     [&](std::uint32_t c) { return judge_.is_good(c) && judge_.is_near(c, most_mm); }))
        return false;
    std::vector<std::uint32_t> cells = above_bound_;
    cells.insert(cells.end(), changed.begin(), changed.end());
    sort_distinct(cells);
    above_after_ = judge_.those_above_bound(std::move(cells));
    return above_after_.size() <= std::max(above_bound_.size(), most_above_);
}

}  // namespace anatomesh
