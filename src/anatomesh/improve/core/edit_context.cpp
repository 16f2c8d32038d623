#include "anatomesh/improve/core/edit_context.h"

#include <algorithm>
#include <iterator>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

EditContext::EditContext(EditMesh& mesh_in, const EditConstraints& constraints_in,
                         const StructureField& field, std::uint32_t structures,
                         const MeshImprovementOptions& options_in)
    : mesh(mesh_in), constraints(constraints_in), probe(field, structures), options(options_in) {
    rule.max_radius_edge = options.max_radius_edge;
}

void EditContext::fix_on_edge(std::uint32_t v, std::uint32_t a, std::uint32_t b) {
    constraints.fix(v);
    if (rule.guards_sections) {
        const std::uint32_t slice = slice_vertices_.slice_of(a, drawn->slice_of);
        if (slice != no_slice && slice == slice_vertices_.slice_of(b, drawn->slice_of))
            slice_vertices_.add(v, slice);
    }
    for (const std::uint32_t end : {a, b}) constraints.fix_edge(v, end);
}

bool EditContext::spoils_section(std::uint32_t a, std::uint32_t b, std::uint32_t c, Region above,
                                 Region below) {
    if (!rule.guards_sections) return false;
    const std::uint32_t slice = slice_vertices_.slice_of(a, drawn->slice_of);
    if (slice == no_slice || slice_vertices_.slice_of(b, drawn->slice_of) != slice ||
        slice_vertices_.slice_of(c, drawn->slice_of) != slice)
        return false;
    const std::vector<std::uint32_t>&one = table->members[above], &other = table->members[below];
    std::vector<std::uint32_t> both;
    std::set_union(one.begin(), one.end(), other.begin(), other.end(), std::back_inserter(both));
    return both != probe.members((1.0 / 3.0) * (mesh.point(a) + mesh.point(b) + mesh.point(c)));
}

double EditContext::sine(const Cell& c) const {
    return least_sine(mesh.point(c[0]), mesh.point(c[1]), mesh.point(c[2]), mesh.point(c[3]));
}

QualityThreshold EditContext::threshold_of(std::span<const std::uint32_t> cells_in) const {
    QualityThreshold threshold;
    for (const std::uint32_t n : cells_in) {
        const Cell& c = mesh.cell(n);
        if (!counts(mesh.region(n), c)) {
            threshold.outside_sine = std::min(threshold.outside_sine, sine(c));
            continue;
        }
        const CellMeasures m =
            measure_cell(mesh.point(c[0]), mesh.point(c[1]), mesh.point(c[2]), mesh.point(c[3]));
        threshold.sine = std::min(threshold.sine, m.least_sine());
        threshold.squared_ratio = std::max(threshold.squared_ratio, m.squared_ratio);
    }
    return threshold;
}

double EditContext::value(const Cell& c, Region region, const QualityThreshold& threshold) const {
    if (!counts(region, c)) {
        const double outside = sine(c);
        return outside > 0 && outside >= rule.needed_outside_sine(threshold) ? 1 : -1;
    }
    const CellMeasures m =
        measure_cell(mesh.point(c[0]), mesh.point(c[1]), mesh.point(c[2]), mesh.point(c[3]));
    const double inside = m.least_sine();
    return inside > 0 && m.squared_ratio <= rule.allowed_squared_ratio(threshold) ? inside : -1;
}

bool EditContext::commit(std::span<const std::uint32_t> removed, std::span<const Cell> added,
                         std::span<const Region> new_regions) {
    for (const Cell& c : added) {
        if (orient3d(mesh.point(c[0]), mesh.point(c[1]), mesh.point(c[2]), mesh.point(c[3])) <= 0)
            return false;
    }
    if (constraints.keeps_any_edge() && std::any_of(removed.begin(), removed.end(), [&](std::uint32_t n) {
            return constraints.loses_kept_edge(mesh.cell(n), added);
        }))
        return false;
    if (speculation.active) {
        CellExchange& cells = speculation.proposal.cells;
        cells.removed.assign(removed.begin(), removed.end());
        cells.added.assign(added.begin(), added.end());
        cells.regions.assign(new_regions.begin(), new_regions.end());
        return true;
    }
    mesh.replace(removed, added, new_regions, changed);
    return true;
}

std::uint32_t EditContext::split_ring(Vec3 at) {
    const std::uint32_t a = ring.a, b = ring.b;
    const bool was_fixed = constraints.fixed_edge(a, b);
    const std::uint32_t v = add_point(at);
    std::vector<Cell>& cells = scratch.cells;
    std::vector<Region>& regions = scratch.regions;
    cells.clear();
    regions.clear();
    for (const std::uint32_t c : ring.cells) {
        for (const std::uint32_t end : {a, b}) {
            cells.push_back(mesh.cell(c));
            std::replace(cells.back().begin(), cells.back().end(), end, v);
            regions.push_back(mesh.region(c));
        }
    }
    if (!commit(ring.cells, cells, regions)) return no_cell;
    if (was_fixed) fix_on_edge(v, a, b);
    return v;
}

bool EditContext::commit_move(std::uint32_t v, Vec3 to) {
    if (speculation.active) {
        speculation.proposal.vertex = v;
        speculation.proposal.to = to;
        return true;
    }
    const Vec3 from = mesh.point(v);
    mesh.move_point(v, to);
    if (!positive(star)) {
        mesh.move_point(v, from);
        return false;
    }
    changed = star;
    return true;
}

bool EditContext::carry_out(const Proposal& change) {
    if (change.lone != no_cell && mesh.edge_on_interface(change.lone, change.lone_edge)) return false;
    if (change.vertex == no_cell) {
        mesh.replace(change.cells.removed, change.cells.added, change.cells.regions, changed);
    } else {
        mesh.star(change.vertex, star);
        if (!commit_move(change.vertex, change.to)) return false;
    }
    ++(stats.operations.*change.counter);
    return true;
}

bool EditContext::positive(std::span<const std::uint32_t> cells_in) const {
    return std::all_of(cells_in.begin(), cells_in.end(), [&](std::uint32_t n) {
        const Cell& c = mesh.cell(n);
        return orient3d(mesh.point(c[0]), mesh.point(c[1]), mesh.point(c[2]), mesh.point(c[3])) > 0;
    });
}

void EditContext::look_between(Region here, Region there) {
    if (table) probe.focus_between(table->members[here], table->members[there]);
}

std::array<std::uint32_t, 2> others_of_facet(const Cell& cell, int facet, std::uint32_t vertex) {
    const auto& corner = facet_vertices[facet];
    std::array<std::uint32_t, 3> f{cell[corner[0]], cell[corner[1]], cell[corner[2]]};
    while (f[0] != vertex) f = {f[1], f[2], f[0]};
    return {f[1], f[2]};
}

bool surface_facets_at(EditContext& edit, std::uint32_t vertex,
                       std::vector<std::array<std::uint32_t, 2>>& facets) {
    const Region side = edit.mesh.region(edit.star[0]);
    Region other = side;
    for (const std::uint32_t c : edit.star) {
        const Region region = edit.mesh.region(c);
        if (region != side) {
            if (other == side) other = region;
            if (region != other) return false;
            continue;
        }
        const Cell& cell = edit.mesh.cell(c);
        for (int i = 0; i < 4; ++i) {
            if (cell[i] == vertex) continue;
            const std::uint32_t n = edit.mesh.neighbor(c, i);
            if (n == no_cell) return false;
            if (edit.mesh.region(n) == side) continue;
            facets.push_back(others_of_facet(cell, i, vertex));
        }
    }
    edit.look_between(side, other);
    return true;
}

}  // namespace anatomesh
