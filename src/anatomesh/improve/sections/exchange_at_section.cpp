#include <algorithm>
#include <array>
#include <vector>

#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/improve/sections/section_operations.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// Cells inside that do not keep the bounds.
std::size_t count_bad(const EditContext& edit, const std::vector<std::uint32_t>& cells,
                      const CellBounds& bounds) {
    return static_cast<std::size_t>(std::count_if(cells.begin(), cells.end(), [&](std::uint32_t c) {
        if (edit.mesh.region(c) == 0) return false;
        const Cell& v = edit.mesh.cell(c);
        const CellMeasures m = measure_cell(edit.mesh.point(v[0]), edit.mesh.point(v[1]),
                                            edit.mesh.point(v[2]), edit.mesh.point(v[3]));
        return m.least_sine() < bounds.sine || m.squared_ratio > bounds.ratio * bounds.ratio;
    }));
}

// The cells at either of two vertices.
std::vector<std::uint32_t> stars_of(const EditContext& edit, std::uint32_t a, std::uint32_t b) {
    std::vector<std::uint32_t> cells, more;
    edit.mesh.star(a, cells);
    edit.mesh.star(b, more);
    for (const std::uint32_t c : more) {
        if (std::find(cells.begin(), cells.end(), c) == cells.end()) cells.push_back(c);
    }
    return cells;
}

// Does an operation that exchanges these cells, and undoes it unless their sections gain enough.
template <class Operation>
bool try_exchange(SectionEdit& section, const std::vector<std::uint32_t>& round, const Operation& operation) {
    const double before = section.areas.wrong(round);
    section.edit.mesh.begin_attempt();
    const bool done =
        operation() && SectionEdit::is_enough(section.areas.wrong(section.edit.changed), before);
    section.edit.mesh.end_attempt(done);
    return done;
}

}  // namespace

bool flip_across_plane(SectionEdit& section, std::uint32_t cell, int e, const CellBounds& bounds) {
    EditContext& edit = section.edit;
    edit.mesh.ring(cell, e, edit.ring);
    const std::vector<std::uint32_t> round = edit.ring.cells;
    return try_exchange(section, round, [&] { return flip_edge(edit, cell, e, bounds.sine); });
}

bool collapse_across_plane(SectionEdit& section, std::uint32_t cell, int e, bool first_onto_second,
                           const CellBounds& bounds) {
    EditContext& edit = section.edit;
    const auto& [i, j] = cell_edges[static_cast<std::size_t>(e)];
    const std::uint32_t from = edit.mesh.cell(cell)[first_onto_second ? i : j],
                        to = edit.mesh.cell(cell)[first_onto_second ? j : i];
    const std::vector<std::uint32_t> round = stars_of(edit, from, to);
    const std::size_t bad = count_bad(edit, round, bounds);
    // Sections are compared over all cells at the vertex that stays.
    const auto operation = [&] {
        if (!collapse_edge_within(edit, cell, e, first_onto_second, bounds.sine, bounds.ratio)) return false;
        edit.mesh.star(to, edit.changed);
        return count_bad(edit, edit.changed, bounds) <= bad;
    };
    if (!try_exchange(section, round, operation)) return false;
    if (!edit.constraints.fixed(to)) edit.constraints.settle(to);
    return true;
}

}  // namespace anatomesh
