#include "anatomesh/improve/core/quality_gate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// Share of the cells inside that surgeries may bring above the first bound: the certificate allows 0.005. [1;
// 0 to 0.005; M 2026-11, set not recorded]
constexpr double most_above_bound = 0.003;

}  // namespace

bool QualityGate::is_good(std::uint32_t c) const {
    if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) return true;
    const Cell& v = edit_.mesh.cell(c);
    const bool constraint_limited = drawn_.are_constraint_limited(v);
    const CellMeasures m = measure_cell(edit_.mesh.point(v[0]), edit_.mesh.point(v[1]),
                                        edit_.mesh.point(v[2]), edit_.mesh.point(v[3]));
    const double most = constraint_limited ? most_limited_ratio : edit_.options.last_radius_edge;
    return m.least_sine() >= (constraint_limited ? least_limited_sine : least_sine_) &&
           m.squared_ratio <= most * most;
}

bool QualityGate::is_near(std::uint32_t c, double most_mm) {
    return !any_distance(c, most_mm, [&](double mm) { return mm > most_mm; });
}

double QualityGate::farthest_of(std::span<const std::uint32_t> cells) {
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
bool QualityGate::any_distance(std::uint32_t c, double reach_mm, const Is& is) {
    if (!edit_.mesh.alive(c)) return false;
    const Cell& cell = edit_.mesh.cell(c);
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t other = edit_.mesh.neighbor(c, i);
        if (other == no_cell || edit_.mesh.region(other) == edit_.mesh.region(c)) continue;
        edit_.look_between(edit_.mesh.region(c), edit_.mesh.region(other));
        const auto& f = facet_vertices[i];
        if (is(edit_.facet_distance(edit_.mesh.point(cell[f[0]]), edit_.mesh.point(cell[f[1]]),
                                    edit_.mesh.point(cell[f[2]]))))
            return true;
        for (const int k : f) {
            if (!edit_.constraints.fixed(cell[k]) &&
                is(edit_.probe.distance(edit_.mesh.point(cell[k]), reach_mm)))
                return true;
        }
    }
    return false;
}

std::vector<std::uint32_t> QualityGate::those_above_bound(std::vector<std::uint32_t> cells) const {
    const double most = edit_.options.max_radius_edge;
    std::erase_if(cells, [&](std::uint32_t c) {
        if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) return true;
        const Cell& v = edit_.mesh.cell(c);
        return drawn_.are_constraint_limited(v) ||
               !(squared_radius_edge(edit_.mesh.point(v[0]), edit_.mesh.point(v[1]), edit_.mesh.point(v[2]),
                                     edit_.mesh.point(v[3])) > most * most);
    });
    return cells;
}

QualityBudget::QualityBudget(EditContext& edit, const DrawnSlices& drawn, double least_sine)
    : gate_(edit, drawn, least_sine) {
    std::vector<std::uint32_t> all = edit.mesh.alive_cells();
    inside_ = static_cast<std::size_t>(
        std::count_if(all.begin(), all.end(), [&](std::uint32_t c) { return edit.mesh.region(c) != 0; }));
    most_above_ = static_cast<std::size_t>(most_above_bound * static_cast<double>(inside_));
    above_bound_ = gate_.those_above_bound(std::move(all));
}

std::optional<std::size_t> QualityBudget::growth(std::span<const std::uint32_t> changed, double most_mm) {
    if (!std::all_of(changed.begin(), changed.end(),
                     [&](std::uint32_t c) { return gate_.is_good(c) && gate_.is_near(c, most_mm); }))
        return std::nullopt;
    std::vector<std::uint32_t> cells = above_bound_;
    cells.insert(cells.end(), changed.begin(), changed.end());
    sort_distinct(cells);
    above_after_ = gate_.those_above_bound(std::move(cells));
    return above_after_.size() - std::min(above_after_.size(), above_bound_.size());
}

}  // namespace anatomesh
