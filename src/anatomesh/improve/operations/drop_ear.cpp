#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// The vertex of a cell that three facets on one surface meet at, and the region beyond them.
struct Ear {
    int tip = -1;  // position in the cell; -1 when the cell is no ear
    Region beyond = 0;
};

Ear ear_of(const Workbench& bench, std::uint32_t cell) {
    const Region own = bench.mesh.region(cell);
    Ear ear;
    int inner = 0;
    bool first = true;
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t n = bench.mesh.neighbor(cell, i);
        if (n == no_cell) return {};
        const Region region = bench.mesh.region(n);
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

bool is_ear(const Workbench& bench, std::uint32_t cell) {
    return ear_of(bench, cell).tip >= 0;
}

bool drop_ear(Workbench& bench, std::uint32_t cell, double least_sine_inside) {
    const Ear ear = ear_of(bench, cell);
    if (ear.tip < 0) return false;
    const Cell& c = bench.mesh.cell(cell);
    if (bench.fixed(c[ear.tip])) return false;
    const auto& base = facet_vertices[ear.tip];
    const Vec3 tip = bench.mesh.point(c[ear.tip]), p = bench.mesh.point(c[base[0]]),
               q = bench.mesh.point(c[base[1]]), r = bench.mesh.point(c[base[2]]);
    bench.look_between(bench.mesh.region(cell), ear.beyond);
    const double before = bench.probe.distance(tip);
    if (before <= bench.options.max_deviation_mm || bench.facet_distance(p, q, r) >= before) return false;
    const double most = bench.options.max_radius_edge;
    const bool inside = ear.beyond != 0;
    if (inside && (bench.sine(cell) < least_sine_inside || squared_radius_edge(tip, p, q, r) > most * most))
        return false;
    bench.mesh.set_region(cell, ear.beyond);
    bench.changed.assign(1, cell);
    ++bench.stats.ears_dropped;
    return true;
}

}  // namespace anatomesh
