#include <algorithm>

#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// Whether (a, b, c) is a facet between two regions. Uses context.others.
bool is_surface_facet(EditContext& edit, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    edit.mesh.star(a, edit.scratch.others);
    for (const std::uint32_t n : edit.scratch.others) {
        const Cell& cell = edit.mesh.cell(n);
        for (int i = 0; i < 4; ++i) {
            if (cell[i] == a || cell[i] == b || cell[i] == c) continue;
            const bool has_both = std::find(cell.begin(), cell.end(), b) != cell.end() &&
                                  std::find(cell.begin(), cell.end(), c) != cell.end();
            const std::uint32_t beyond = edit.mesh.neighbor(n, i);
            if (has_both && beyond != no_cell && edit.mesh.region(beyond) != edit.mesh.region(n)) return true;
        }
    }
    return false;
}

// A vertex of a surface between two regions may go along an edge of it, if the only neighbours on the surface
// that both ends share are the two across the edge (link condition, Dey, Edelsbrunner, Guha and Nekhayev,
// Publ. Inst. Math. 66, 1999), and if the surface stays near the field's interface.
bool may_leave_surface(EditContext& edit, std::uint32_t from, std::uint32_t to, double most_distance) {
    std::vector<std::array<std::uint32_t, 2>> rim;  // of the disc round `from`
    if (!surface_facets_at(edit, from, rim)) return false;
    const Region side = edit.mesh.region(edit.star[0]);
    Region other = side;
    for (const std::uint32_t c : edit.star) {
        if (edit.mesh.region(c) != side) other = edit.mesh.region(c);
    }
    double before = 0;
    for (const auto& [u, w] : rim) {
        before = std::max(before,
                          edit.facet_distance(edit.mesh.point(from), edit.mesh.point(u), edit.mesh.point(w)));
    }
    int at_edge = 0;
    for (const auto& [u, w] : rim) at_edge += u == to || w == to;
    if (at_edge != 2) return false;
    // The surface of a single cell would vanish.
    if (rim.size() == 3) {
        for (const auto& [u, w] : rim) {
            if (u != to && w != to && is_surface_facet(edit, to, u, w)) return false;
        }
    }
    const Vec3 p = edit.mesh.point(from), q = edit.mesh.point(to);
    for (const auto& [u, w] : rim) {
        if (u == to || w == to) continue;
        const Vec3 pu = edit.mesh.point(u), pw = edit.mesh.point(w);
        const Vec3 old_normal = cross(pu - p, pw - p), new_normal = cross(pu - q, pw - q);
        if (!(dot(old_normal, new_normal) > 0.5 * length(old_normal) * length(new_normal))) return false;
        if (edit.spoils_section(to, u, w, side, other) ||
            !(edit.facet_distance(q, pu, pw) <= std::max(before, most_distance)))
            return false;
    }
    // No edge from `to` to the rest of the rim may lie on an interface yet.
    std::vector<std::uint32_t> across, rest;
    for (const auto& [u, w] : rim) {
        if (u == to) across.push_back(w);
        if (w == to) across.push_back(u);
    }
    for (const auto& [u, w] : rim) {
        if (u != to && std::find(across.begin(), across.end(), u) == across.end()) rest.push_back(u);
    }
    edit.mesh.star(to, edit.scratch.others);
    for (const std::uint32_t c : edit.scratch.others) {
        const Cell& cell = edit.mesh.cell(c);
        for (int e = 0; e < 6; ++e) {
            const std::uint32_t a = cell[cell_edges[e][0]], b = cell[cell_edges[e][1]];
            if (a != to && b != to) continue;
            if (std::find(rest.begin(), rest.end(), a == to ? b : a) == rest.end()) continue;
            if (edit.mesh.edge_on_interface(c, e)) return false;
        }
    }
    return true;
}

// `may_be`: what a new cell in a region must be, when it takes the place of those of context.star.
template <class MayBe>
bool collapse(EditContext& edit, std::uint32_t cell, int e, bool first_onto_second, double most_distance,
              const MayBe& may_be) {
    const std::uint32_t a = edit.mesh.cell(cell)[cell_edges[e][0]],
                        b = edit.mesh.cell(cell)[cell_edges[e][1]];
    const std::uint32_t from = first_onto_second ? a : b, to = first_onto_second ? b : a;
    if (edit.constraints.fixed(from)) return false;
    edit.mesh.star(from, edit.star);
    const QualityThreshold threshold = edit.threshold_of(edit.star);
    edit.scratch.cells.clear();
    edit.scratch.regions.clear();
    bool surface = false;
    for (const std::uint32_t c : edit.star) {
        surface = surface || edit.mesh.region(c) != edit.mesh.region(cell);
        Cell moved = edit.mesh.cell(c);
        if (std::find(moved.begin(), moved.end(), to) != moved.end()) continue;
        std::replace(moved.begin(), moved.end(), from, to);
        if (!may_be(moved, edit.mesh.region(c), threshold)) return false;
        edit.scratch.cells.push_back(moved);
        edit.scratch.regions.push_back(edit.mesh.region(c));
    }
    if (surface && !may_leave_surface(edit, from, to, most_distance)) return false;
    return edit.commit(edit.star, edit.scratch.cells, edit.scratch.regions);
}

}  // namespace

bool collapse_edge(EditContext& edit, std::uint32_t cell, int e, bool first_onto_second) {
    const auto better = [&](const Cell& moved, Region region, const QualityThreshold& threshold) {
        return edit.value(moved, region, threshold) >= edit.rule.needed_sine(threshold);
    };
    if (!collapse(edit, cell, e, first_onto_second, edit.options.max_deviation_mm, better)) return false;
    ++edit.stats.operations.edges_collapsed;
    return true;
}

bool collapse_edge_within(EditContext& edit, std::uint32_t cell, int e, bool first_onto_second,
                          double least_sine_inside, double most_ratio) {
    const auto good_enough = [&](const Cell& moved, Region region, const QualityThreshold& threshold) {
        if (region == 0) return edit.sine(moved) >= edit.rule.needed_outside_sine(threshold);
        const CellMeasures m = measure_cell(edit.mesh.point(moved[0]), edit.mesh.point(moved[1]),
                                            edit.mesh.point(moved[2]), edit.mesh.point(moved[3]));
        return m.least_sine() >= std::min(threshold.sine, least_sine_inside) &&
               m.squared_ratio <= std::max(threshold.squared_ratio, most_ratio * most_ratio);
    };
    return collapse(edit, cell, e, first_onto_second, edit.options.spike_mm, good_enough);
}

}  // namespace anatomesh
