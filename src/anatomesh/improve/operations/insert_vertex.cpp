#include <algorithm>
#include <array>

#include "anatomesh/improve/core/hole.h"
#include "anatomesh/improve/operations/operations.h"

namespace anatomesh {

namespace {

// The new vertex of an edge on a surface between two regions: on the field's interface, its facets near that.
class OnSurface {
  public:
    OnSurface(Workbench& bench, std::array<std::uint32_t, 2> across)
        : bench_(bench), a_(bench.ring.a), b_(bench.ring.b), across_(across) {
        const Vec3 pa = bench.mesh.point(a_), pb = bench.mesh.point(b_);
        for (const std::uint32_t v : across_) {
            before_ = std::max(before_, bench.facet_distance(pa, pb, bench.mesh.point(v)));
        }
        reach_ = 0.3 * length(pb - pa);
        const Vec3 pc = bench.mesh.point(across_[0]), pd = bench.mesh.point(across_[1]);
        normal = normalized(normalized(cross(pb - pa, pc - pa)) + normalized(cross(pd - pa, pb - pa)));
    }

    bool operator()(Vec3& q) const {
        const auto onto = bench_.probe.project(q, reach_, 0.1 * bench_.options.tolerance_mm);
        if (onto) q = *onto;
        if (!onto && bench_.probe.distance(q) > 0.5 * bench_.options.tolerance_mm) return false;
        const Vec3 pa = bench_.mesh.point(a_), pb = bench_.mesh.point(b_);
        double sign = 1;
        for (const std::uint32_t v : across_) {
            const Vec3 pv = bench_.mesh.point(v);
            for (const auto& [s, t] : {std::array<Vec3, 2>{pa, q}, std::array<Vec3, 2>{q, pb}}) {
                const Vec3 area = sign * cross(t - s, pv - s);
                if (!(dot(area, normal) > 0.5 * length(area))) return false;
                if (bench_.facet_distance(s, t, pv) > std::max(before_, bench_.options.max_deviation_mm))
                    return false;
            }
            sign = -sign;
        }
        return true;
    }

    Vec3 normal;

  private:
    Workbench& bench_;
    std::uint32_t a_, b_;
    std::array<std::uint32_t, 2> across_;
    double before_ = 0, reach_ = 0;
};

}  // namespace

bool insert_vertex(Workbench& bench, std::uint32_t cell, int e) {
    bench.mesh.ring(cell, e, bench.ring);
    if (!bench.ring.closed) return false;
    std::array<std::uint32_t, 2> across{};
    std::array<Region, 2> sides{};
    int changes = 0;
    for (std::size_t n = 0; n < bench.ring.cells.size(); ++n) {
        const std::uint32_t before = bench.ring.cells[n == 0 ? bench.ring.cells.size() - 1 : n - 1];
        if (bench.mesh.region(bench.ring.cells[n]) == bench.mesh.region(before)) continue;
        if (changes < 2) {
            across[static_cast<std::size_t>(changes)] = bench.ring.ring[n];
            sides[static_cast<std::size_t>(changes)] = bench.mesh.region(bench.ring.cells[n]);
        }
        ++changes;
    }
    if (changes > 2 || (changes == 2 && bench.fixed_edge(bench.ring.a, bench.ring.b))) return false;
    const Vec3 middle = 0.5 * (bench.mesh.point(bench.ring.a) + bench.mesh.point(bench.ring.b));
    const double most = bench.options.max_radius_edge;
    const auto better = [&](const Bar& bar) { return bench.needed_sine(bar); };
    Hole hole(bench, bench.ring);
    bool done = false;
    if (changes == 2) {
        bench.look_between(sides[0], sides[1]);
        const OnSurface surface(bench, across);
        done = hole.fill(middle, surface.normal, most, better, surface);
    } else {
        const auto anywhere = [](Vec3&) { return true; };
        done = hole.fill(middle, {}, most, better, anywhere);
        if (!done) {
            // Where the edge lies in a flat side of the hole, its middle is no place to start from.
            Hole again(bench, bench.ring);
            done = again.fill(again.centre(), {}, most, better, anywhere);
        }
    }
    bench.stats.vertices_inserted += done;
    return done;
}

}  // namespace anatomesh
