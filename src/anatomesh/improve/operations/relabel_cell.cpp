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
    const Workbench& bench;
    bool is_region;
    std::uint32_t number;
    bool holds(std::uint32_t c) const {
        const Region region = bench.mesh.region(c);
        return is_region ? region == number : bench.table->contains(region, number);
    }
};

// What a part's surface gets and loses where a cell comes to it or leaves it.
class SurfaceChange {
  public:
    SurfaceChange(Workbench& bench, std::uint32_t cell, Part part, const ContourOwners* owners)
        : bench_(bench), cell_(cell), part_(part), owners_(owners) {
        for (int i = 0; i < 4; ++i) {
            on_surface_[i] = differs(bench.mesh.neighbor(cell, i));
            count_ += on_surface_[i];
        }
    }

    // Whether a disc takes the place of a disc: what the cell's other facets bring to the surface, apart from
    // its rim, is not on it yet; and what goes is not fixed. A cell that is all there is of its region may
    // go.
    bool keeps_surface() const {
        const Cell& c = bench_.mesh.cell(cell_);
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
    bool must_have(std::uint32_t v) const { return bench_.fixed(v) && is_owner(v); }
    bool must_have(std::uint32_t a, std::uint32_t b) const {
        return bench_.fixed_edge(a, b) && is_owner(a) && is_owner(b);
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
        bench_.mesh.star(v, bench_.star);
        return any_differs(bench_.star);
    }
    bool edge_on_surface(int e) const {
        bench_.mesh.ring(cell_, e, bench_.ring);
        return !bench_.ring.closed || any_differs(bench_.ring.cells);
    }

    Workbench& bench_;
    std::uint32_t cell_;
    Part part_;
    const ContourOwners* owners_;
    std::array<bool, 4> on_surface_{};
    int count_ = 0;
};

// The surfaces of the structures concerned and of both regions stay manifolds.
bool keeps_surfaces(Workbench& bench, std::uint32_t cell, Region from, Region to,
                    const ContourOwners* owners = nullptr) {
    for (const Region region : {from, to}) {
        if (!SurfaceChange(bench, cell, {bench, true, region}, owners).keeps_surface()) return false;
    }
    const std::vector<std::uint32_t>&here = bench.table->members[from], &there = bench.table->members[to];
    std::vector<std::uint32_t> changed;
    std::set_symmetric_difference(here.begin(), here.end(), there.begin(), there.end(),
                                  std::back_inserter(changed));
    return std::all_of(changed.begin(), changed.end(), [&](std::uint32_t structure) {
        return SurfaceChange(bench, cell, {bench, false, structure}, owners).keeps_surface();
    });
}

int facets_between_regions(const Workbench& bench, std::uint32_t cell, Region own) {
    int count = 0;
    for (int i = 0; i < 4; ++i) count += bench.mesh.region(bench.mesh.neighbor(cell, i)) != own;
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

// Of cells of one region. What lies within `still` of the wall as it was does not move it, however far from
// the field's that is.
bool keeps_near(Workbench& bench, std::span<const std::uint32_t> cells, Region to, double most,
                double still = 0) {
    const Region own = bench.mesh.region(cells.front());
    double before = 0;
    Wall wall;
    for (const bool was : {true, false}) {
        for (const std::uint32_t c : cells) {
            const Cell cell = bench.mesh.cell(c);
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t other = bench.mesh.neighbor(c, i);
                if (std::find(cells.begin(), cells.end(), other) != cells.end()) continue;
                const Region beyond = bench.mesh.region(other);
                const auto& f = facet_vertices[i];
                const Vec3 p = bench.mesh.point(cell[f[0]]), q = bench.mesh.point(cell[f[1]]),
                           r = bench.mesh.point(cell[f[2]]);
                const auto distance = [&] { return bench.facet_distance(p, q, r); };
                bench.look_between(beyond, was ? own : to);
                if (was && beyond != own) {
                    before = std::max(before, distance());
                    if (beyond == to) wall.add(p, q, r);
                } else if (!was && beyond != to) {
                    if (bench.spoils_cut(cell[f[0]], cell[f[1]], cell[f[2]], beyond, to)) return false;
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
bool is_at_junction(const Workbench& bench, std::uint32_t cell, Region to) {
    for (int i = 0; i < 4; ++i) {
        const Region region = bench.mesh.region(bench.mesh.neighbor(cell, i));
        if (region != bench.mesh.region(cell) && region != to) return true;
    }
    return false;
}

// Those that come to the surface lie near the field's: the middles of facets may although a corner does not.
bool has_near_vertices(Workbench& bench, std::uint32_t cell, Region to, double most) {
    bench.look_between(bench.mesh.region(cell), to);
    const Cell& c = bench.mesh.cell(cell);
    return std::all_of(c.begin(), c.end(), [&](std::uint32_t v) {
        return bench.fixed(v) || bench.probe.distance(bench.mesh.point(v), most) <= most;
    });
}

bool ends_the_mesh(const Workbench& bench, std::uint32_t cell) {
    for (int i = 0; i < 4; ++i) {
        if (bench.mesh.neighbor(cell, i) == no_cell) return true;
    }
    return false;
}

// Those that come inside have a shape for it.
bool may_be_of(const Workbench& bench, std::span<const std::uint32_t> cells, double least_sine_inside,
               double most_ratio) {
    return std::all_of(cells.begin(), cells.end(), [&](std::uint32_t cell) {
        if (ends_the_mesh(bench, cell)) return false;
        if (bench.mesh.region(cell) != 0) return true;
        const Cell& c = bench.mesh.cell(cell);
        const CellMeasures m = measure_cell(bench.mesh.point(c[0]), bench.mesh.point(c[1]),
                                            bench.mesh.point(c[2]), bench.mesh.point(c[3]));
        return m.least_sine() >= least_sine_inside && m.squared_ratio <= most_ratio * most_ratio;
    });
}

bool lies_near(Workbench& bench, std::span<const std::uint32_t> cells, Region to) {
    return keeps_near(bench, cells, to, bench.options.spike_mm) &&
           std::all_of(cells.begin(), cells.end(), [&](std::uint32_t c) {
               return has_near_vertices(bench, c, to, bench.options.spike_mm);
           });
}

// The same of several cells of one region; the mesh is as before afterwards.
bool keeps_surfaces(Workbench& bench, std::span<const std::uint32_t> cells, Region to,
                    const ContourOwners& owners) {
    const Region own = bench.mesh.region(cells.front());
    SurfaceCount count(bench, owners, cells, to);
    const SurfaceCount::Figures before = count.figures();
    for (const std::uint32_t c : cells) bench.mesh.set_region(c, to);
    const SurfaceCount::Figures after = count.figures();
    const bool kept =
        after.excess == 0 && after.characteristics == before.characteristics && count.newly_lost() == 0;
    for (const std::uint32_t c : cells) bench.mesh.set_region(c, own);
    return kept;
}

}  // namespace

bool may_relabel(Workbench& bench, std::uint32_t cell, Region to, const ContourOwners& owners,
                 double least_sine_inside, double most_ratio) {
    const std::array cells{cell};
    return may_be_of(bench, cells, least_sine_inside, most_ratio) &&
           keeps_surfaces(bench, cell, bench.mesh.region(cell), to, &owners) && lies_near(bench, cells, to);
}

bool may_relabel_all(Workbench& bench, std::span<const std::uint32_t> cells, Region to,
                     const ContourOwners& owners, double least_sine_inside, double most_ratio) {
    return may_be_of(bench, cells, least_sine_inside, most_ratio) && lies_near(bench, cells, to) &&
           keeps_surfaces(bench, cells, to, owners);
}

bool relabel_cell(Workbench& bench, std::uint32_t cell) {
    const Region own = bench.mesh.region(cell);
    if (ends_the_mesh(bench, cell)) return false;
    const int now = facets_between_regions(bench, cell, own);
    for (int i = 0; i < 4; ++i) {
        const Region to = bench.mesh.region(bench.mesh.neighbor(cell, i));
        if (to == own || (to != 0 && facets_between_regions(bench, cell, to) >= now)) continue;
        if (!keeps_surfaces(bench, cell, own, to) ||
            !keeps_near(bench, std::array{cell}, to, bench.options.max_deviation_mm,
                        is_at_junction(bench, cell, to) ? bench.options.tolerance_mm : 0))
            continue;
        bench.mesh.set_region(cell, to);
        bench.changed.assign(1, cell);
        ++bench.stats.cells_relabelled;
        return true;
    }
    return false;
}

}  // namespace anatomesh
