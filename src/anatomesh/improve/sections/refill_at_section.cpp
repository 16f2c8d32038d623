#include <algorithm>
#include <array>
#include <iterator>
#include <vector>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/sections/section_operations.h"

namespace anatomesh {

namespace {

// Heights of a new vertex over a plane, in heights of the cell, or in mean lengths of edges.
// [1; 0 to 1; M 2026-11, set not recorded]
constexpr std::array lifts{0.1, 0.2, 0.3, 0.45, 0.06, 0.03};

// The vertex of a cell that a facet of another cell does not have.
std::uint32_t apex_over(const EditMesh& mesh, std::uint32_t side, const Cell& cell, int facet) {
    const auto& f = facet_vertices[facet];
    for (const std::uint32_t v : mesh.cell(side)) {
        if (v != cell[f[0]] && v != cell[f[1]] && v != cell[f[2]]) return v;
    }
    return no_cell;
}

// The cells of a region at a vertex, and those of their facets at it where another region begins.
struct RegionStar {
    std::uint32_t vertex;
    Region own, to;
    std::vector<std::uint32_t> cells, round;  // round: their vertices, rising
    std::vector<Hole::CellFacet> at_surface;
};

// False where other regions than `to` are beside them, or none, or the mesh ends.
bool find_region_star(EditMesh& mesh, RegionStar& star) {
    std::vector<std::uint32_t> all;
    mesh.star(star.vertex, all);
    std::copy_if(all.begin(), all.end(), std::back_inserter(star.cells),
                 [&](std::uint32_t c) { return mesh.region(c) == star.own; });
    for (const std::uint32_t c : star.cells) {
        const Cell& cell = mesh.cell(c);
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t beyond = mesh.neighbor(c, i);
            star.round.push_back(cell[i]);
            // A facet that does not have the vertex stays between what it lies between.
            if (cell[i] == star.vertex) continue;
            if (beyond == no_cell) return false;
            if (mesh.region(beyond) == star.own) continue;
            if (mesh.region(beyond) != star.to) return false;
            star.at_surface.push_back({c, i});
        }
    }
    return !star.at_surface.empty();
}

// To a new vertex over plane k, or, with `over` -1, under it.
bool leave_for(SectionEdit& section, const RegionStar& star, std::uint32_t k, double over, double before,
               const CellBounds& bounds) {
    EditContext& edit = section.edit;
    const Plane& plane = section.areas.plane(k);
    const Vec3 from = edit.mesh.point(star.vertex);
    const double depth = plane.signed_distance(from), most = edit.options.spike_mm;
    double edges = 0;
    for (const std::uint32_t c : star.cells) {
        for (const std::uint32_t u : edit.mesh.cell(c)) edges += length(edit.mesh.point(u) - from);
    }
    const double edge = edges / (3.0 * static_cast<double>(star.cells.size()));
    const auto may_lie = [&](Vec3& q) {
        edit.look_between(star.own, star.to);
        return over * plane.signed_distance(q) > 0 && edit.probe.distance(q, most) <= most;
    };
    const auto needed_sine = [&](const QualityThreshold&) { return bounds.sine; };
    for (const double share : lifts) {
        const Vec3 p = from + (over * share * edge - depth) * plane.normal;
        const auto added = static_cast<std::uint32_t>(edit.mesh.point_count());
        edit.mesh.begin_attempt();
        const bool done = Hole(edit, star.cells, star.at_surface)
                              .fill(p, plane.normal, bounds.ratio, needed_sine, may_lie) &&
                          SectionEdit::is_enough(section.areas.wrong(edit.changed), before);
        edit.mesh.end_attempt(done);
        if (!done) continue;
        edit.constraints.settle(added);
        return true;
    }
    return false;
}

}  // namespace

bool refill_beside_plane(SectionEdit& section, std::uint32_t c, int i, const CellBounds& bounds) {
    EditContext& edit = section.edit;
    SectionAreas& areas = section.areas;
    const std::uint32_t other = edit.mesh.neighbor(c, i);
    const Cell cell = edit.mesh.cell(c);
    const auto& f = facet_vertices[i];
    const std::uint32_t k = areas.plane_of(std::array{cell[f[0]], cell[f[1]], cell[f[2]]});
    if (k == no_slice) return false;
    const Vec3 a = edit.mesh.point(cell[f[0]]), b = edit.mesh.point(cell[f[1]]),
               d = edit.mesh.point(cell[f[2]]);
    const double before = areas.wrong_at(c, i);
    for (const std::uint32_t side : {c, other}) {
        const Vec3 top = edit.mesh.point(apex_over(edit.mesh, side, cell, i));
        // Then the plane has there what is on the other side.
        const Region under = edit.mesh.region(side == c ? other : c);
        if (!SectionEdit::is_enough(areas.wrong_facet(a, b, d, k, under, under), before)) continue;
        const auto above = [&](Vec3& q) {
            return areas.plane(k).signed_distance(q) * areas.plane(k).signed_distance(top) > 0;
        };
        const Refill refill{{c, other}, {}, (1.0 / 3) * (a + b + d), top};
        const std::uint32_t v = refill_from_heights(edit, refill, lifts, bounds, above);
        if (v == no_cell) continue;
        edit.constraints.settle(v);
        return true;
    }
    return false;
}

bool leave_vertex_beyond_plane(SectionEdit& section, std::uint32_t v, Region own, Region to,
                               const CellBounds& bounds) {
    RegionStar star{v, own, to, {}, {}, {}};
    if (!find_region_star(section.edit.mesh, star)) return false;
    const double before = section.areas.wrong(star.cells);
    if (!section.is_worth_it(before)) return false;
    sort_distinct(star.round);
    return section.areas.any_plane_at(star.round, [&](std::uint32_t k) {
        const int side = section.areas.side(v, k);
        return (side <= 0 && leave_for(section, star, k, 1, before, bounds)) ||
               (side >= 0 && leave_for(section, star, k, -1, before, bounds));
    });
}

}  // namespace anatomesh
