#include <algorithm>
#include <array>
#include <iterator>

#include "anatomesh/improve/operations.h"

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
    SurfaceChange(Workbench& bench, std::uint32_t cell, Part part) : bench_(bench), cell_(cell), part_(part) {
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
        if (count_ == 3) return !bench_.fixed(c[first(false)]);
        if (count_ == 4) return part_.is_region && part_.holds(cell_);
        if (count_ == 0) return false;
        // The facets opposite i and j share the edge of the other two vertices; the edge ij comes to the
        // surface.
        int e = 0;
        while (!on_surface_[cell_edges[e][0]] || !on_surface_[cell_edges[e][1]]) ++e;
        const auto [k, l] = across_edges[e];
        return !bench_.fixed_edge(c[k], c[l]) && !edge_on_surface(e);
    }

  private:
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
    std::array<bool, 4> on_surface_{};
    int count_ = 0;
};

// The surfaces of the structures concerned and of both regions stay manifolds.
bool keeps_surfaces(Workbench& bench, std::uint32_t cell, Region from, Region to) {
    for (const Region region : {from, to}) {
        if (!SurfaceChange(bench, cell, {bench, true, region}).keeps_surface()) return false;
    }
    const std::vector<std::uint32_t>&here = bench.table->members[from], &there = bench.table->members[to];
    std::vector<std::uint32_t> changed;
    std::set_symmetric_difference(here.begin(), here.end(), there.begin(), there.end(),
                                  std::back_inserter(changed));
    return std::all_of(changed.begin(), changed.end(), [&](std::uint32_t structure) {
        return SurfaceChange(bench, cell, {bench, false, structure}).keeps_surface();
    });
}

int facets_between_regions(const Workbench& bench, std::uint32_t cell, Region own) {
    int count = 0;
    for (int i = 0; i < 4; ++i) count += bench.mesh.region(bench.mesh.neighbor(cell, i)) != own;
    return count;
}

bool keeps_near(Workbench& bench, std::uint32_t cell, Region to) {
    const Cell c = bench.mesh.cell(cell);
    double before = 0;
    for (const bool was : {true, false}) {
        for (int i = 0; i < 4; ++i) {
            const Region beyond = bench.mesh.region(bench.mesh.neighbor(cell, i));
            const auto& f = facet_vertices[i];
            bench.look_between(beyond, was ? bench.mesh.region(cell) : to);
            if (was && beyond != bench.mesh.region(cell)) {
                before = std::max(before,
                                  bench.facet_distance(bench.mesh.point(c[f[0]]), bench.mesh.point(c[f[1]]),
                                                       bench.mesh.point(c[f[2]])));
            } else if (!was && beyond != to &&
                       (bench.spoils_cut(c[f[0]], c[f[1]], c[f[2]], beyond, to) ||
                        !bench.near_interface(c[f[0]], c[f[1]], c[f[2]], before))) {
                return false;
            }
        }
    }
    return true;
}

}  // namespace

bool give_cell(Workbench& bench, std::uint32_t cell) {
    const Region own = bench.mesh.region(cell);
    for (int i = 0; i < 4; ++i) {
        if (bench.mesh.neighbor(cell, i) == no_cell) return false;
    }
    const int now = facets_between_regions(bench, cell, own);
    for (int i = 0; i < 4; ++i) {
        const Region to = bench.mesh.region(bench.mesh.neighbor(cell, i));
        if (to == own || (to != 0 && facets_between_regions(bench, cell, to) >= now)) continue;
        if (!keeps_surfaces(bench, cell, own, to) || !keeps_near(bench, cell, to)) continue;
        bench.mesh.set_region(cell, to);
        bench.changed.assign(1, cell);
        ++bench.stats.cells_given;
        return true;
    }
    return false;
}

}  // namespace anatomesh
