#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// The vertex of a cell that three facets on one surface meet at, and the region beyond them.
struct Ear {
    int tip = -1;  // position in the cell; -1 when the cell is no ear
    Region beyond = 0;
};

Ear ear_of(const EditContext& edit, std::uint32_t cell) {
    const Region own = edit.mesh.region(cell);
    Ear ear;
    int inner = 0;
    bool first = true;
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t n = edit.mesh.neighbor(cell, i);
        if (n == no_cell) return {};
        const Region region = edit.mesh.region(n);
        if (region == own) {
            ++inner;
            ear.tip = i;
        } else if (first || region == ear.beyond) {
            ear.beyond = region;
            first = false;
        } else {
            return {};
        }
    }
    return inner == 1 ? ear : Ear{};
}

}  // namespace

bool is_ear(const EditContext& edit, std::uint32_t cell) {
    return ear_of(edit, cell).tip >= 0;
}

bool drop_ear(EditContext& edit, std::uint32_t cell, double least_sine_inside) {
    const Ear ear = ear_of(edit, cell);
    if (ear.tip < 0) return false;
    const Cell& c = edit.mesh.cell(cell);
    if (edit.constraints.fixed(c[ear.tip])) return false;
    const auto& base = facet_vertices[ear.tip];
    const Vec3 tip = edit.mesh.point(c[ear.tip]), p = edit.mesh.point(c[base[0]]),
               q = edit.mesh.point(c[base[1]]), r = edit.mesh.point(c[base[2]]);
    edit.look_between(edit.mesh.region(cell), ear.beyond);
    const double before = edit.probe.distance(tip);
    if (before <= edit.options.max_deviation_mm || edit.facet_distance(p, q, r) >= before) return false;
    const double most = edit.options.max_radius_edge;
    const bool inside = ear.beyond != 0;
    if (inside && (edit.sine(cell) < least_sine_inside || squared_radius_edge(tip, p, q, r) > most * most))
        return false;
    edit.mesh.set_region(cell, ear.beyond);
    edit.changed.assign(1, cell);
    ++edit.stats.ears_dropped;
    return true;
}

}  // namespace anatomesh
