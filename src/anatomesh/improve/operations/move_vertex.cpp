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
bool surface_fan(EditContext& edit, std::uint32_t v, SurfaceFan& fan) {
    if (!surface_facets_at(edit, v, fan.facets)) return false;
    Vec3 sum;
    for (const auto& [u, w] : fan.facets) {
        sum += cross(edit.mesh.point(u) - edit.mesh.point(v), edit.mesh.point(w) - edit.mesh.point(v));
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
    Slide(EditContext& edit, std::uint32_t v, SurfaceFan& fan)
        : edit_(edit), v_(v), fan_(fan), start_(edit.mesh.point(v)) {}

    bool operator()(Vec3& q) {
        if (!known_) measure();
        const auto onto = edit_.probe.project(q, 0.5 * length(q - start_) + edit_.options.tolerance_mm,
                                              0.1 * edit_.options.tolerance_mm);
        if (onto) q = *onto;
        if (!onto && edit_.probe.distance(q) > std::max(distance_, 0.5 * edit_.options.tolerance_mm))
            return false;
        for (const auto& [b, c] : fan_.facets) {
            const Vec3 pb = edit_.mesh.point(b), pc = edit_.mesh.point(c);
            const Vec3 before = cross(pb - start_, pc - start_), after = cross(pb - q, pc - q);
            if (!(dot(before, after) > 0.5 * length(before) * length(after))) return false;
            if (edit_.facet_distance(q, pb, pc) >
                std::max(fan_.worst_distance, edit_.options.max_deviation_mm))
                return false;
        }
        return true;
    }

  private:
    void measure() {
        known_ = true;
        distance_ = edit_.probe.distance(start_);
        for (const auto& [b, c] : fan_.facets) {
            fan_.worst_distance = std::max(
                fan_.worst_distance, edit_.facet_distance(start_, edit_.mesh.point(b), edit_.mesh.point(c)));
        }
    }
    EditContext& edit_;
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
    Shift(EditContext& edit, std::uint32_t v) : edit_(edit), start_(edit.mesh.point(v)) {
        for (const std::uint32_t c : edit.star) {
            const Cell& cell = edit.mesh.cell(c);
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t n = edit.mesh.neighbor(c, i);
                if (cell[i] == v || n == no_cell || n < c || edit.mesh.region(n) == edit.mesh.region(c))
                    continue;
                std::array<std::uint32_t, 3> f{cell[facet_vertices[i][0]], cell[facet_vertices[i][1]],
                                               cell[facet_vertices[i][2]]};
                while (f[0] != v) f = {f[1], f[2], f[0]};
                const Vec3 b = edit.mesh.point(f[1]), c1 = edit.mesh.point(f[2]);
                const Region here = edit.mesh.region(c), there = edit.mesh.region(n);
                edit.look_between(here, there);
                const double now = edit.facet_distance(start_, b, c1);
                facets_.push_back({b, c1, here, there, std::max(now, edit.options.max_deviation_mm)});
            }
        }
    }

    bool operator()(Vec3& q) const {
        if (length(q - start_) > edit_.options.max_deviation_mm) return false;
        return std::all_of(facets_.begin(), facets_.end(), [&](const Facet& f) {
            const Vec3 before = cross(f.b - start_, f.c - start_), after = cross(f.b - q, f.c - q);
            if (!(dot(before, after) > 0.5 * length(before) * length(after))) return false;
            edit_.look_between(f.here, f.there);
            return edit_.facet_distance(q, f.b, f.c) <= f.most;
        });
    }

  private:
    struct Facet {
        Vec3 b, c;
        Region here, there;
        double most;  // distance of its middle from the field's interfaces
    };
    EditContext& edit_;
    Vec3 start_;
    std::vector<Facet> facets_;
};

}  // namespace

bool move_vertex(EditContext& edit, std::uint32_t v) {
    if (edit.constraints.fixed(v)) return false;
    if (edit.speculation.active) {
        edit.mesh.shared_star(v, edit.star);
    } else {
        edit.mesh.star(v, edit.star);
    }
    const QualityThreshold threshold = edit.threshold_of(edit.star);
    const double needed = edit.rule.needed_sine(threshold);
    edit.scratch.local.reset(edit.rule.needed_outside_sine(threshold),
                             edit.rule.allowed_squared_ratio(threshold));
    bool surface = false;
    for (const std::uint32_t c : edit.star) {
        const Cell& cell = edit.mesh.cell(c);
        surface = surface || edit.mesh.region(c) != edit.mesh.region(edit.star[0]);
        int i = 0;
        while (cell[i] != v) ++i;
        // (p, facet) is positive when the facet runs counter-clockwise seen from outside.
        const auto& f = facet_vertices[i];
        edit.scratch.local.add(edit.mesh.point(cell[f[0]]), edit.mesh.point(cell[f[1]]),
                               edit.mesh.point(cell[f[2]]), edit.counts(edit.mesh.region(c), cell));
    }
    SurfaceFan fan;
    const bool junction = surface && !surface_fan(edit, v, fan);
    if (junction && !edit.rule.moves_junctions) return false;
    const Vec3 from = edit.mesh.point(v);
    Vec3 p = from;
    const auto always = [](Vec3&) { return true; };
    const double reached =
        junction  ? edit.scratch.local.ascend(p, threshold.sine, edit.goal, {}, Shift(edit, v))
        : surface ? edit.scratch.local.ascend(p, threshold.sine, edit.goal, fan.normal, Slide(edit, v, fan))
                  : edit.scratch.local.ascend(p, threshold.sine, edit.goal, {}, always);
    if (reached < needed || p == from || !edit.commit_move(v, p)) return false;
    edit.count(surface ? &OperationCounts::surface_vertices_moved : &OperationCounts::vertices_moved);
    return true;
}

}  // namespace anatomesh
