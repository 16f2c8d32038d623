#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <vector>

#include "anatomesh/geom/point_triangle.h"
#include "anatomesh/improve/core/surface_count.h"
#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// The cells of a structure, or of a region.
struct Part {
    const EditContext& edit;
    bool is_region;
    std::uint32_t number;
    bool holds(std::uint32_t c) const {
        const Region region = edit.mesh.region(c);
        return is_region ? region == number : edit.table->contains(region, number);
    }
};

// What a part's surface gets and loses where a cell comes to it or leaves it.
class SurfaceChange {
  public:
    SurfaceChange(EditContext& edit, std::uint32_t cell, Part part, const ContourOwners* owners)
        : edit_(edit), cell_(cell), part_(part), owners_(owners) {
        for (int i = 0; i < 4; ++i) {
            on_surface_[i] = differs(edit.mesh.neighbor(cell, i));
            count_ += on_surface_[i];
        }
    }

    // Whether a disc takes the place of a disc: what the cell's other facets bring to the surface, apart from
    // its rim, is not on it yet; and what goes is not fixed. A cell that is all there is of its region may
    // go.
    bool keeps_surface() const {
        const Cell& c = edit_.mesh.cell(cell_);
        if (count_ == 1) return !vertex_on_surface(c[first(true)]);
        if (count_ == 3) return !must_have(c[first(false)]);
        if (count_ == 4) return part_.is_region && part_.holds(cell_);
        if (count_ == 0) return false;
        // The facets opposite i and j share the edge of the other two vertices; the edge ij comes to the
        // surface.
        int e = 0;
        while (!on_surface_[cell_edges[e][0]] || !on_surface_[cell_edges[e][1]]) ++e;
        const auto [k, l] = across_edges[e];
        return !must_have(c[k], c[l]) && !edge_on_surface(e);
    }

  private:
    // Whether a vertex, or an edge, must stay on the surface: of those that are fixed all where nothing is
    // known of owners.
    bool must_have(std::uint32_t v) const { return edit_.constraints.fixed(v) && is_owner(v); }
    bool must_have(std::uint32_t a, std::uint32_t b) const {
        return edit_.constraints.fixed_edge(a, b) && is_owner(a) && is_owner(b);
    }
    bool is_owner(std::uint32_t v) const {
        return !owners_ || !owners_->knows(v) || (!part_.is_region && owners_->has(v, part_.number));
    }
    bool differs(std::uint32_t c) const { return part_.holds(c) != part_.holds(cell_); }
    int first(bool on) const {
        return static_cast<int>(std::find(on_surface_.begin(), on_surface_.end(), on) - on_surface_.begin());
    }
    bool any_differs(const std::vector<std::uint32_t>& cells) const {
        return std::any_of(cells.begin(), cells.end(), [&](std::uint32_t c) { return differs(c); });
    }
    bool vertex_on_surface(std::uint32_t v) const {
        edit_.mesh.star(v, edit_.star);
        return any_differs(edit_.star);
    }
    bool edge_on_surface(int e) const {
        edit_.mesh.ring(cell_, e, edit_.ring);
        return !edit_.ring.closed || any_differs(edit_.ring.cells);
    }

    EditContext& edit_;
    std::uint32_t cell_;
    Part part_;
    const ContourOwners* owners_;
    std::array<bool, 4> on_surface_{};
    int count_ = 0;
};

// The surfaces of the structures concerned and of both regions stay manifolds.
bool keeps_surfaces(EditContext& edit, std::uint32_t cell, Region from, Region to,
                    const ContourOwners* owners = nullptr) {
    for (const Region region : {from, to}) {
        if (!SurfaceChange(edit, cell, {edit, true, region}, owners).keeps_surface()) return false;
    }
    const std::vector<std::uint32_t>&here = edit.table->members[from], &there = edit.table->members[to];
    std::vector<std::uint32_t> changed;
    std::set_symmetric_difference(here.begin(), here.end(), there.begin(), there.end(),
                                  std::back_inserter(changed));
    return std::all_of(changed.begin(), changed.end(), [&](std::uint32_t structure) {
        return SurfaceChange(edit, cell, {edit, false, structure}, owners).keeps_surface();
    });
}

int facets_between_regions(const EditContext& edit, std::uint32_t cell, Region own) {
    int count = 0;
    for (int i = 0; i < 4; ++i) count += edit.mesh.region(edit.mesh.neighbor(cell, i)) != own;
    return count;
}

// The facets in which one region met another.
class Wall {
  public:
    void add(Vec3 a, Vec3 b, Vec3 c) { facets_.push_back({a, b, c}); }
    bool is_within(double mm, Vec3 p) const {
        return std::any_of(facets_.begin(), facets_.end(), [&](const std::array<Vec3, 3>& f) {
            return point_triangle_distance(p, f[0], f[1], f[2]) <= mm;
        });
    }

  private:
    std::vector<std::array<Vec3, 3>> facets_;
};

// Whether the surface stays near the field's if cells of one region are relabelled. A facet within `still` of
// the wall as it was does not move it, however far from the field's that is.
bool keeps_near(EditContext& edit, std::span<const std::uint32_t> cells, Region to, double most,
                double still = 0) {
    const Region own = edit.mesh.region(cells.front());
    double before = 0;
    Wall wall;
    for (const bool was : {true, false}) {
        for (const std::uint32_t c : cells) {
            const Cell cell = edit.mesh.cell(c);
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t other = edit.mesh.neighbor(c, i);
                if (std::find(cells.begin(), cells.end(), other) != cells.end()) continue;
                const Region beyond = edit.mesh.region(other);
                const auto& f = facet_vertices[i];
                const Vec3 p = edit.mesh.point(cell[f[0]]), q = edit.mesh.point(cell[f[1]]),
                           r = edit.mesh.point(cell[f[2]]);
                const auto distance = [&] { return edit.facet_distance(p, q, r); };
                edit.look_between(beyond, was ? own : to);
                if (was && beyond != own) {
                    before = std::max(before, distance());
                    if (beyond == to) wall.add(p, q, r);
                } else if (!was && beyond != to) {
                    if (edit.spoils_section(cell[f[0]], cell[f[1]], cell[f[2]], beyond, to)) return false;
                    const bool stays =
                        still > 0 && beyond == own && wall.is_within(still, (1.0 / 3) * (p + q + r));
                    if (!stays && distance() > std::max(before, most)) return false;
                }
            }
        }
    }
    return true;
}

// Whether a third region lies at the cell: there facets between two of them may be far from the field's
// interfaces of both.
bool is_at_junction(const EditContext& edit, std::uint32_t cell, Region to) {
    for (int i = 0; i < 4; ++i) {
        const Region region = edit.mesh.region(edit.mesh.neighbor(cell, i));
        if (region != edit.mesh.region(cell) && region != to) return true;
    }
    return false;
}

// Whether vertices that come to the surface lie near the field's: a facet's middle may although a corner does
// not.
bool has_near_vertices(EditContext& edit, std::uint32_t cell, Region to, double most) {
    edit.look_between(edit.mesh.region(cell), to);
    const Cell& c = edit.mesh.cell(cell);
    return std::all_of(c.begin(), c.end(), [&](std::uint32_t v) {
        return edit.constraints.fixed(v) || edit.probe.distance(edit.mesh.point(v), most) <= most;
    });
}

bool ends_the_mesh(const EditContext& edit, std::uint32_t cell) {
    for (int i = 0; i < 4; ++i) {
        if (edit.mesh.neighbor(cell, i) == no_cell) return true;
    }
    return false;
}

// Whether cells that come inside have a shape for it.
bool may_be_of(const EditContext& edit, std::span<const std::uint32_t> cells, double least_sine_inside,
               double most_ratio) {
    return std::all_of(cells.begin(), cells.end(), [&](std::uint32_t cell) {
        if (ends_the_mesh(edit, cell)) return false;
        if (edit.mesh.region(cell) != 0) return true;
        const Cell& c = edit.mesh.cell(cell);
        const CellMeasures m = measure_cell(edit.mesh.point(c[0]), edit.mesh.point(c[1]),
                                            edit.mesh.point(c[2]), edit.mesh.point(c[3]));
        return m.least_sine() >= least_sine_inside && m.squared_ratio <= most_ratio * most_ratio;
    });
}

bool lies_near(EditContext& edit, std::span<const std::uint32_t> cells, Region to) {
    return keeps_near(edit, cells, to, edit.options.spike_mm) &&
           std::all_of(cells.begin(), cells.end(), [&](std::uint32_t c) {
               return has_near_vertices(edit, c, to, edit.options.spike_mm);
           });
}

// Whether surfaces keep their topology if cells of one region are relabelled together. The mesh stays as it
// is.
bool keeps_surfaces(EditContext& edit, std::span<const std::uint32_t> cells, Region to,
                    const ContourOwners& owners) {
    const Region own = edit.mesh.region(cells.front());
    SurfaceCount count(edit, owners, cells, to);
    const SurfaceCount::Figures before = count.figures();
    for (const std::uint32_t c : cells) edit.mesh.set_region(c, to);
    const SurfaceCount::Figures after = count.figures();
    const bool kept =
        after.excess == 0 && after.characteristics == before.characteristics && count.newly_lost() == 0;
    for (const std::uint32_t c : cells) edit.mesh.set_region(c, own);
    return kept;
}

}  // namespace

bool may_relabel(EditContext& edit, std::uint32_t cell, Region to, const ContourOwners& owners,
                 double least_sine_inside, double most_ratio) {
    const std::array cells{cell};
    return may_be_of(edit, cells, least_sine_inside, most_ratio) &&
           keeps_surfaces(edit, cell, edit.mesh.region(cell), to, &owners) && lies_near(edit, cells, to);
}

bool may_relabel_all(EditContext& edit, std::span<const std::uint32_t> cells, Region to,
                     const ContourOwners& owners, double least_sine_inside, double most_ratio) {
    return may_be_of(edit, cells, least_sine_inside, most_ratio) && lies_near(edit, cells, to) &&
           keeps_surfaces(edit, cells, to, owners);
}

bool relabel_cell(EditContext& edit, std::uint32_t cell) {
    const Region own = edit.mesh.region(cell);
    if (ends_the_mesh(edit, cell)) return false;
    const int now = facets_between_regions(edit, cell, own);
    for (int i = 0; i < 4; ++i) {
        const Region to = edit.mesh.region(edit.mesh.neighbor(cell, i));
        if (to == own || (to != 0 && facets_between_regions(edit, cell, to) >= now)) continue;
        if (!keeps_surfaces(edit, cell, own, to) ||
            !keeps_near(edit, std::array{cell}, to, edit.options.max_deviation_mm,
                        is_at_junction(edit, cell, to) ? edit.options.tolerance_mm : 0) ||
            !has_near_vertices(edit, cell, to, edit.options.max_deviation_mm))
            continue;
        edit.mesh.set_region(cell, to);
        edit.changed.assign(1, cell);
        ++edit.stats.operations.cells_relabelled;
        return true;
    }
    return false;
}

}  // namespace anatomesh
