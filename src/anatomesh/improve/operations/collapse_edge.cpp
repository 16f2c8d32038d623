#include <algorithm>

#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// Whether (a, b, c) is a facet between two regions. Uses bench.others.
bool is_surface_facet(Workbench& bench, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    bench.mesh.star(a, bench.others);
    for (const std::uint32_t n : bench.others) {
        const Cell& cell = bench.mesh.cell(n);
        for (int i = 0; i < 4; ++i) {
            if (cell[i] == a || cell[i] == b || cell[i] == c) continue;
            const bool has_both = std::find(cell.begin(), cell.end(), b) != cell.end() &&
                                  std::find(cell.begin(), cell.end(), c) != cell.end();
            const std::uint32_t beyond = bench.mesh.neighbor(n, i);
            if (has_both && beyond != no_cell && bench.mesh.region(beyond) != bench.mesh.region(n))
                return true;
        }
    }
    return false;
}

// A vertex of a surface between two regions may go along an edge of it, if the only neighbours on the surface
// that both ends share are the two across the edge (link condition, Dey, Edelsbrunner, Guha and Nekhayev,
// Publ. Inst. Math. 66, 1999), and if the surface stays near the field's interface.
bool may_leave_surface(Workbench& bench, std::uint32_t from, std::uint32_t to, double most_distance) {
    std::vector<std::array<std::uint32_t, 2>> rim;  // of the disc round `from`
    if (!surface_facets_at(bench, from, rim)) return false;
    const Region side = bench.mesh.region(bench.star[0]);
    Region other = side;
    for (const std::uint32_t c : bench.star) {
        if (bench.mesh.region(c) != side) other = bench.mesh.region(c);
    }
    double before = 0;
    for (const auto& [u, w] : rim) {
        before = std::max(
            before, bench.facet_distance(bench.mesh.point(from), bench.mesh.point(u), bench.mesh.point(w)));
    }
    int at_edge = 0;
    for (const auto& [u, w] : rim) at_edge += u == to || w == to;
    if (at_edge != 2) return false;
    // The surface of a single cell would vanish.
    if (rim.size() == 3) {
        for (const auto& [u, w] : rim) {
            if (u != to && w != to && is_surface_facet(bench, to, u, w)) return false;
        }
    }
    const Vec3 p = bench.mesh.point(from), q = bench.mesh.point(to);
    for (const auto& [u, w] : rim) {
        if (u == to || w == to) continue;
        const Vec3 pu = bench.mesh.point(u), pw = bench.mesh.point(w);
        const Vec3 old_normal = cross(pu - p, pw - p), new_normal = cross(pu - q, pw - q);
        if (!(dot(old_normal, new_normal) > 0.5 * length(old_normal) * length(new_normal))) return false;
        if (bench.spoils_cut(to, u, w, side, other) ||
            !(bench.facet_distance(q, pu, pw) <= std::max(before, most_distance)))
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
    bench.mesh.star(to, bench.others);
    for (const std::uint32_t c : bench.others) {
        const Cell& cell = bench.mesh.cell(c);
        for (int e = 0; e < 6; ++e) {
            const std::uint32_t a = cell[cell_edges[e][0]], b = cell[cell_edges[e][1]];
            if (a != to && b != to) continue;
            if (std::find(rest.begin(), rest.end(), a == to ? b : a) == rest.end()) continue;
            if (bench.mesh.edge_on_interface(c, e)) return false;
        }
    }
    return true;
}

// `may_be`: what a new cell in a region must be, when it takes the place of those of bench.star.
template <class MayBe>
bool collapse(Workbench& bench, std::uint32_t cell, int e, bool first_onto_second, double most_distance,
              const MayBe& may_be) {
    const std::uint32_t a = bench.mesh.cell(cell)[cell_edges[e][0]],
                        b = bench.mesh.cell(cell)[cell_edges[e][1]];
    const std::uint32_t from = first_onto_second ? a : b, to = first_onto_second ? b : a;
    if (bench.fixed(from)) return false;
    bench.mesh.star(from, bench.star);
    const Bar bar = bench.bar_of(bench.star);
    bench.cells.clear();
    bench.regions.clear();
    bool surface = false;
    for (const std::uint32_t c : bench.star) {
        surface = surface || bench.mesh.region(c) != bench.mesh.region(cell);
        Cell moved = bench.mesh.cell(c);
        if (std::find(moved.begin(), moved.end(), to) != moved.end()) continue;
        std::replace(moved.begin(), moved.end(), from, to);
        if (!may_be(moved, bench.mesh.region(c), bar)) return false;
        bench.cells.push_back(moved);
        bench.regions.push_back(bench.mesh.region(c));
    }
    if (surface && !may_leave_surface(bench, from, to, most_distance)) return false;
    return bench.commit(bench.star, bench.cells, bench.regions);
}

}  // namespace

bool collapse_edge(Workbench& bench, std::uint32_t cell, int e, bool first_onto_second) {
    const auto better = [&](const Cell& moved, Region region, const Bar& bar) {
        return bench.value(moved, region, bar) >= bench.needed_sine(bar);
    };
    if (!collapse(bench, cell, e, first_onto_second, bench.options.max_deviation_mm, better)) return false;
    ++bench.stats.edges_collapsed;
    return true;
}

bool collapse_edge_within(Workbench& bench, std::uint32_t cell, int e, bool first_onto_second,
                          double least_sine_inside, double most_ratio) {
    const auto good_enough = [&](const Cell& moved, Region region, const Bar& bar) {
        if (region == 0) return bench.sine(moved) >= bench.needed_outside_sine(bar);
        const CellMeasures m = measure_cell(bench.mesh.point(moved[0]), bench.mesh.point(moved[1]),
                                            bench.mesh.point(moved[2]), bench.mesh.point(moved[3]));
        return m.least_sine() >= std::min(bar.sine, least_sine_inside) &&
               m.squared_ratio <= std::max(bar.squared_ratio, most_ratio * most_ratio);
    };
    return collapse(bench, cell, e, first_onto_second, bench.options.spike_mm, good_enough);
}

}  // namespace anatomesh
