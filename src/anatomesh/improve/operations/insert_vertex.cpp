#include <algorithm>
#include <array>

#include "anatomesh/improve/core/hole.h"
#include "anatomesh/improve/operations/operations.h"

namespace anatomesh {

namespace {

// The new vertex of an edge on a surface between two regions: on the field's interface, its facets near that.
class OnSurface {
  public:
    OnSurface(EditContext& edit, std::array<std::uint32_t, 2> across)
        : edit_(edit), a_(edit.ring.a), b_(edit.ring.b), across_(across) {
        const Vec3 pa = edit.mesh.point(a_), pb = edit.mesh.point(b_);
        for (const std::uint32_t v : across_) {
            before_ = std::max(before_, edit.facet_distance(pa, pb, edit.mesh.point(v)));
        }
        reach_ = 0.3 * length(pb - pa);
        const Vec3 pc = edit.mesh.point(across_[0]), pd = edit.mesh.point(across_[1]);
        normal = normalized(normalized(cross(pb - pa, pc - pa)) + normalized(cross(pd - pa, pb - pa)));
    }

    bool operator()(Vec3& q) const {
        const auto onto = edit_.probe.project(q, reach_, 0.1 * edit_.options.tolerance_mm);
        if (onto) q = *onto;
        if (!onto && edit_.probe.distance(q) > 0.5 * edit_.options.tolerance_mm) return false;
        const Vec3 pa = edit_.mesh.point(a_), pb = edit_.mesh.point(b_);
        double sign = 1;
        for (const std::uint32_t v : across_) {
            const Vec3 pv = edit_.mesh.point(v);
            for (const auto& [s, t] : {std::array<Vec3, 2>{pa, q}, std::array<Vec3, 2>{q, pb}}) {
                const Vec3 area = sign * cross(t - s, pv - s);
                if (!(dot(area, normal) > 0.5 * length(area))) return false;
                if (edit_.facet_distance(s, t, pv) > std::max(before_, edit_.options.max_deviation_mm))
                    return false;
            }
            sign = -sign;
        }
        return true;
    }

    Vec3 normal;

  private:
    EditContext& edit_;
    std::uint32_t a_, b_;
    std::array<std::uint32_t, 2> across_;
    double before_ = 0, reach_ = 0;
};

}  // namespace

bool insert_vertex(EditContext& edit, std::uint32_t cell, int e) {
    edit.mesh.ring(cell, e, edit.ring);
    if (!edit.ring.closed) return false;
    std::array<std::uint32_t, 2> across{};
    std::array<Region, 2> sides{};
    int changes = 0;
    for (std::size_t n = 0; n < edit.ring.cells.size(); ++n) {
        const std::uint32_t before = edit.ring.cells[n == 0 ? edit.ring.cells.size() - 1 : n - 1];
        if (edit.mesh.region(edit.ring.cells[n]) == edit.mesh.region(before)) continue;
        if (changes < 2) {
            across[static_cast<std::size_t>(changes)] = edit.ring.ring[n];
            sides[static_cast<std::size_t>(changes)] = edit.mesh.region(edit.ring.cells[n]);
        }
        ++changes;
    }
    if (changes > 2 || (changes == 2 && edit.constraints.fixed_edge(edit.ring.a, edit.ring.b))) return false;
    const Vec3 middle = 0.5 * (edit.mesh.point(edit.ring.a) + edit.mesh.point(edit.ring.b));
    const double most = edit.rule.max_radius_edge;
    const auto better = [&](const QualityThreshold& threshold) { return edit.rule.needed_sine(threshold); };
    Hole hole(edit, edit.ring);
    bool done = false;
    if (changes == 2) {
        edit.look_between(sides[0], sides[1]);
        const OnSurface surface(edit, across);
        done = hole.fill(middle, surface.normal, most, better, surface);
    } else {
        const auto anywhere = [](Vec3&) { return true; };
        done = hole.fill(middle, {}, most, better, anywhere);
        if (!done) {
            // Where the edge lies in a flat side of the hole, its middle is no place to start from.
            Hole again(edit, edit.ring);
            done = again.fill(again.centre(), {}, most, better, anywhere);
        }
    }
    edit.stats.operations.vertices_inserted += done;
    return done;
}

}  // namespace anatomesh
