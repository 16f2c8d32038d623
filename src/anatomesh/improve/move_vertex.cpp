#include <algorithm>
#include <cmath>

#include "anatomesh/improve/cell_shape.h"
#include "anatomesh/improve/operations.h"

namespace anatomesh {

namespace {

// The facets between two regions at a vertex, as seen from the cells of one side; the vertex comes first.
struct SurfaceFan {
    std::vector<std::array<std::uint32_t, 2>> facets;  // the other two vertices
    Vec3 normal;                                       // mean, of length 1
    double worst_distance = 0;                         // of a facet's middle from the field's interface
};

// False where three or more regions meet, or the mesh ends.
bool surface_fan(Workbench& bench, std::uint32_t v, SurfaceFan& fan) {
    if (!surface_facets_at(bench, v, fan.facets)) return false;
    Vec3 sum;
    for (const auto& [u, w] : fan.facets) {
        sum += cross(bench.mesh.point(u) - bench.mesh.point(v), bench.mesh.point(w) - bench.mesh.point(v));
    }
    const double size = length(sum);
    if (!(size > 0)) return false;
    fan.normal = (1 / size) * sum;
    return true;
}

// Slides a vertex along its surface: tried places are moved onto the field's interface; the facets may not
// turn over nor leave the field's interface.
class Slide {
  public:
    Slide(Workbench& bench, std::uint32_t v, SurfaceFan& fan)
        : bench_(bench), v_(v), fan_(fan), start_(bench.mesh.point(v)) {}

    bool operator()(Vec3& q) {
        if (!known_) measure();
        const auto onto = bench_.probe.project(q, 0.5 * length(q - start_) + bench_.options.tolerance_mm,
                                               0.1 * bench_.options.tolerance_mm);
        if (onto) q = *onto;
        if (!onto && bench_.probe.distance(q) > std::max(distance_, 0.5 * bench_.options.tolerance_mm))
            return false;
        for (const auto& [b, c] : fan_.facets) {
            const Vec3 pb = bench_.mesh.point(b), pc = bench_.mesh.point(c);
            const Vec3 before = cross(pb - start_, pc - start_), after = cross(pb - q, pc - q);
            if (!(dot(before, after) > 0.5 * length(before) * length(after))) return false;
            if (bench_.facet_distance(q, pb, pc) >
                std::max(fan_.worst_distance, bench_.options.max_deviation_mm))
                return false;
        }
        return true;
    }

  private:
    void measure() {
        known_ = true;
        distance_ = bench_.probe.distance(start_);
        for (const auto& [b, c] : fan_.facets) {
            fan_.worst_distance =
                std::max(fan_.worst_distance,
                         bench_.facet_distance(start_, bench_.mesh.point(b), bench_.mesh.point(c)));
        }
    }
    Workbench& bench_;
    std::uint32_t v_;
    SurfaceFan& fan_;
    Vec3 start_;
    bool known_ = false;
    double distance_ = 0;
};

}  // namespace

bool move_vertex(Workbench& bench, std::uint32_t v) {
    if (bench.fixed(v)) return false;
    if (bench.scouts) {
        bench.mesh.shared_star(v, bench.star);
    } else {
        bench.mesh.star(v, bench.star);
    }
    const Bar bar = bench.bar_of(bench.star);
    const double needed = bench.needed_sine(bar);
    bench.local.reset(bench.needed_outside_sine(bar), bench.allowed_squared_ratio(bar));
    bool surface = false;
    for (const std::uint32_t c : bench.star) {
        const Cell& cell = bench.mesh.cell(c);
        surface = surface || bench.mesh.region(c) != bench.mesh.region(bench.star[0]);
        int i = 0;
        while (cell[i] != v) ++i;
        // (p, facet) is positive when the facet runs counter-clockwise seen from outside.
        const auto& f = facet_vertices[i];
        bench.local.add(bench.mesh.point(cell[f[0]]), bench.mesh.point(cell[f[1]]),
                        bench.mesh.point(cell[f[2]]), bench.mesh.region(c) != 0);
    }
    SurfaceFan fan;
    if (surface && !surface_fan(bench, v, fan)) return false;
    const Vec3 from = bench.mesh.point(v);
    Vec3 p = from;
    const auto always = [](Vec3&) { return true; };
    const double reached = surface
                               ? bench.local.ascend(p, bar.sine, bench.goal, fan.normal, Slide(bench, v, fan))
                               : bench.local.ascend(p, bar.sine, bench.goal, {}, always);
    if (reached < needed) return false;
    if (bench.scouts) return true;
    bench.mesh.move_point(v, p);
    if (!bench.positive(bench.star)) {
        bench.mesh.move_point(v, from);
        return false;
    }
    bench.changed = bench.star;
    ++(surface ? bench.stats.surface_vertices_moved : bench.stats.vertices_moved);
    return true;
}

}  // namespace anatomesh
