#include <algorithm>
#include <array>
#include <iterator>

#include "anatomesh/improve/operations.h"

namespace anatomesh {

namespace {

// What a structure's surface gets and loses where a cell changes sides.
class SurfaceChange {
  public:
    SurfaceChange(Workbench& bench, std::uint32_t cell, std::uint32_t structure)
        : bench_(bench), cell_(cell), structure_(structure) {
        for (int i = 0; i < 4; ++i) {
            on_surface_[i] = in(bench.mesh.neighbor(cell, i)) != in(cell);
            count_ += on_surface_[i];
        }
    }

    // Whether a disc takes the place of a disc: what the cell's other facets bring to the surface, apart from
    // its rim, is not on it yet; and what goes is not fixed.
    bool keeps_surface() const {
        const Cell& c = bench_.mesh.cell(cell_);
        if (count_ == 1) return !vertex_on_surface(c[first(true)]);
        if (count_ == 3) return !bench_.fixed(c[first(false)]);
        if (count_ != 2) return false;
        // The facets opposite i and j share the edge of the other two vertices; the edge ij comes to the
        // surface.
        int e = 0;
        while (!on_surface_[cell_edges[e][0]] || !on_surface_[cell_edges[e][1]]) ++e;
        const auto [k, l] = across_edges[e];
        return !bench_.fixed_edge(c[k], c[l]) && !edge_on_surface(e);
    }

  private:
    bool in(std::uint32_t c) const { return bench_.table->contains(bench_.mesh.region(c), structure_); }
    int first(bool on) const {
        return static_cast<int>(std::find(on_surface_.begin(), on_surface_.end(), on) - on_surface_.begin());
    }
    bool vertex_on_surface(std::uint32_t v) const {
        bench_.mesh.star(v, bench_.star);
        return std::any_of(bench_.star.begin(), bench_.star.end(),
                           [&](std::uint32_t c) { return in(c) != in(cell_); });
    }
    bool edge_on_surface(int e) const {
        bench_.mesh.ring(cell_, e, bench_.ring);
        return !bench_.ring.closed || std::any_of(bench_.ring.cells.begin(), bench_.ring.cells.end(),
                                                  [&](std::uint32_t c) { return in(c) != in(cell_); });
    }
    Workbench& bench_;
    std::uint32_t cell_, structure_;
    std::array<bool, 4> on_surface_{};
    int count_ = 0;
};

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
        const std::vector<std::uint32_t>&here = bench.table->members[own], &there = bench.table->members[to];
        std::vector<std::uint32_t> changed;
        std::set_symmetric_difference(here.begin(), here.end(), there.begin(), there.end(),
                                      std::back_inserter(changed));
        const bool sound = std::all_of(changed.begin(), changed.end(), [&](std::uint32_t structure) {
            return SurfaceChange(bench, cell, structure).keeps_surface();
        });
        if (!sound || !keeps_near(bench, cell, to)) continue;
        bench.mesh.set_region(cell, to);
        bench.changed.assign(1, cell);
        ++bench.stats.cells_given;
        return true;
    }
    return false;
}

}  // namespace anatomesh
