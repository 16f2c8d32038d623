#include <algorithm>
#include <cmath>

#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/mesh/shape/cell_shape.h"

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

// Moves a vertex where three or more regions meet: there is no one surface to slide along. It keeps near to
// where it was; the facets between regions may not turn over nor leave the field's interfaces.
class Shift {
  public:
    Shift(Workbench& bench, std::uint32_t v) : bench_(bench), start_(bench.mesh.point(v)) {
        for (const std::uint32_t c : bench.star) {
            const Cell& cell = bench.mesh.cell(c);
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t n = bench.mesh.neighbor(c, i);
                if (cell[i] == v || n == no_cell || n < c || bench.mesh.region(n) == bench.mesh.region(c))
                    continue;
                std::array<std::uint32_t, 3> f{cell[facet_vertices[i][0]], cell[facet_vertices[i][1]],
                                               cell[facet_vertices[i][2]]};
                while (f[0] != v) f = {f[1], f[2], f[0]};
                const Vec3 b = bench.mesh.point(f[1]), c1 = bench.mesh.point(f[2]);
                const Region here = bench.mesh.region(c), there = bench.mesh.region(n);
                bench.look_between(here, there);
                const double now = bench.facet_distance(start_, b, c1);
                facets_.push_back({b, c1, here, there, std::max(now, bench.options.max_deviation_mm)});
            }
        }
    }

    bool operator()(Vec3& q) const {
        if (length(q - start_) > bench_.options.max_deviation_mm) return false;
        return std::all_of(facets_.begin(), facets_.end(), [&](const Facet& f) {
            const Vec3 before = cross(f.b - start_, f.c - start_), after = cross(f.b - q, f.c - q);
            if (!(dot(before, after) > 0.5 * length(before) * length(after))) return false;
            bench_.look_between(f.here, f.there);
            return bench_.facet_distance(q, f.b, f.c) <= f.most;
        });
    }

  private:
    struct Facet {
        Vec3 b, c;
        Region here, there;
        double most;  // distance of its middle from the field's interfaces
    };
    Workbench& bench_;
    Vec3 start_;
    std::vector<Facet> facets_;
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
                        bench.mesh.point(cell[f[2]]), bench.counts(bench.mesh.region(c), cell));
    }
    SurfaceFan fan;
    const bool junction = surface && !surface_fan(bench, v, fan);
    if (junction && !bench.moves_junctions) return false;
    const Vec3 from = bench.mesh.point(v);
    Vec3 p = from;
    const auto always = [](Vec3&) { return true; };
    const double reached = junction ? bench.local.ascend(p, bar.sine, bench.goal, {}, Shift(bench, v))
                           : surface
                               ? bench.local.ascend(p, bar.sine, bench.goal, fan.normal, Slide(bench, v, fan))
                               : bench.local.ascend(p, bar.sine, bench.goal, {}, always);
    if (reached < needed || p == from || !bench.commit_move(v, p)) return false;
    bench.count(surface ? &DihedralStats::surface_vertices_moved : &DihedralStats::vertices_moved);
    return true;
}

}  // namespace anatomesh
