#include <utility>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/surgery/remove_spikes.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// Cells that a thread looks at in a row. [cells; > 0; B]
constexpr std::size_t cells_in_a_row = 16384;

// The vertex of a cell at which three facets on one surface meet, and the region beyond them.
struct CellSpike {
    int apex = -1;  // position in the cell; -1 if the cell is no spike
    Region beyond = 0;
};

CellSpike cell_spike_of(const EditContext& edit, std::uint32_t cell) {
    const Region own = edit.mesh.region(cell);
    CellSpike spike;
    int inner = 0;
    bool first = true;
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t n = edit.mesh.neighbor(cell, i);
        if (n == no_cell) return {};
        const Region region = edit.mesh.region(n);
        if (region == own) {
            ++inner;
            spike.apex = i;
        } else if (first || region == spike.beyond) {
            spike.beyond = region;
            first = false;
        } else {
            return {};
        }
    }
    return inner == 1 ? spike : CellSpike{};
}

// Relabels the cell if it is a spike that the field has not, and says whether it did.
bool remove_cell_spike(EditContext& edit, std::uint32_t cell, double least_sine) {
    const CellSpike spike = cell_spike_of(edit, cell);
    if (spike.apex < 0) return false;
    const Cell& c = edit.mesh.cell(cell);
    if (edit.constraints.fixed(c[spike.apex])) return false;
    const auto& base = facet_vertices[spike.apex];
    const Vec3 apex = edit.mesh.point(c[spike.apex]), p = edit.mesh.point(c[base[0]]),
               q = edit.mesh.point(c[base[1]]), r = edit.mesh.point(c[base[2]]);
    edit.look_between(edit.mesh.region(cell), spike.beyond);
    const double before = edit.probe.distance(apex);
    if (before <= edit.options.max_deviation_mm || edit.facet_distance(p, q, r) >= before) return false;
    const double most = edit.options.max_radius_edge;
    const bool inside = spike.beyond != 0;
    if (inside && (edit.sine(cell) < least_sine || squared_radius_edge(apex, p, q, r) > most * most))
        return false;
    edit.mesh.set_region(cell, spike.beyond);
    edit.changed.assign(1, cell);
    return true;
}

}  // namespace

std::uint64_t remove_cell_spikes(EditContext& edit, double least_sine, int threads) {
    std::vector<std::uint32_t> cells = parallel_collect<std::uint32_t>(
        edit.mesh.cell_count(), cells_in_a_row, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& spikes) {
            for (std::size_t n = first; n < last; ++n) {
                const auto c = static_cast<std::uint32_t>(n);
                if (edit.mesh.alive(c) && cell_spike_of(edit, c).apex >= 0) spikes.push_back(c);
            }
        });
    std::uint64_t removed = 0;
    while (!cells.empty()) {
        std::vector<std::uint32_t> next;
        for (const std::uint32_t c : cells) {
            if (!edit.mesh.alive(c) || !remove_cell_spike(edit, c, least_sine)) continue;
            ++removed;
            next.push_back(c);
            for (int i = 0; i < 4; ++i) next.push_back(edit.mesh.neighbor(c, i));
        }
        sort_distinct(next);
        cells = std::move(next);
    }
    return removed;
}

}  // namespace anatomesh
