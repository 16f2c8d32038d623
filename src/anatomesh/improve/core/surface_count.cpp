#include "anatomesh/improve/core/surface_count.h"

#include <algorithm>
#include <iterator>

#include "anatomesh/base/sort_distinct.h"

namespace anatomesh {

SurfaceCount::SurfaceCount(EditContext& edit, const ContourOwners& owners,
                           std::span<const std::uint32_t> cells, Region to)
    : edit_(edit), cells_(cells.begin(), cells.end()) {
    std::vector<Region> regions{to};
    for (const std::uint32_t c : cells_) {
        const Region from = edit.mesh.region(c);
        regions.push_back(from);
        const std::vector<std::uint32_t>&here = edit.table->members[from], &there = edit.table->members[to];
        std::set_symmetric_difference(here.begin(), here.end(), there.begin(), there.end(),
                                      std::back_inserter(structures_));
        const Cell& cell = edit.mesh.cell(c);
        vertices_.insert(vertices_.end(), cell.begin(), cell.end());
        for (int e = 0; e < 6; ++e) {
            const std::uint32_t p = cell[cell_edges[e][0]], q = cell[cell_edges[e][1]];
            edges_.push_back({std::min(p, q), std::max(p, q), c, e});
        }
    }
    sort_distinct(regions);
    sort_distinct(structures_);
    sort_distinct(vertices_);
    for (const Region region : regions) bodies_.push_back({true, region});
    region_bodies_ = bodies_.size();
    for (const std::uint32_t structure : structures_) bodies_.push_back({false, structure});
    std::sort(edges_.begin(), edges_.end(), [](const Edge& x, const Edge& y) {
        return std::array{x.a, x.b, x.cell} < std::array{y.a, y.b, y.cell};
    });
    edges_.erase(std::unique(edges_.begin(), edges_.end(),
                             [](const Edge& x, const Edge& y) { return x.a == y.a && x.b == y.b; }),
                 edges_.end());
    for (const std::uint32_t v : vertices_) {
        for (const std::uint32_t s : owners.at(v)) owned_.push_back({v, v, 0, s, 0});
    }
    for (const Edge& edge : edges_) {
        bool known = false;
        for (const ContourOwners::Subsegment& subsegment : owners.subsegments_at(edge.a)) {
            if (subsegment.other != edge.b) continue;
            owned_.push_back({edge.a, edge.b, edge.cell, subsegment.structure, edge.index});
            known = true;
        }
        if (known || !edit.constraints.fixed_edge(edge.a, edge.b)) continue;
        for (const std::uint32_t s : structures_)
            owned_.push_back({edge.a, edge.b, edge.cell, s, edge.index});
    }
    std::erase_if(owned_, [&](const Owned& owned) { return !on_surface(owned); });
}

SurfaceCount::Figures SurfaceCount::figures() {
    Figures figures;
    for (const std::uint32_t v : vertices_) figures.excess += excess_at(v);
    for (const Body& body : bodies_) figures.characteristics.push_back(characteristic(body));
    return figures;
}

std::span<const int> SurfaceCount::of_structures(const Figures& figures) const {
    return std::span(figures.characteristics).subspan(region_bodies_);
}

std::size_t SurfaceCount::newly_lost() {
    return static_cast<std::size_t>(
        std::count_if(owned_.begin(), owned_.end(), [&](const Owned& owned) { return !on_surface(owned); }));
}

bool SurfaceCount::mixed(const Body& body, const std::vector<std::uint32_t>& cells) const {
    return std::any_of(cells.begin(), cells.end(),
                       [&](std::uint32_t c) { return holds(body, c) != holds(body, cells.front()); });
}

bool SurfaceCount::on_surface(const Owned& owned) {
    const Body body{false, owned.structure};
    if (owned.a == owned.b) {
        edit_.mesh.star(owned.a, edit_.star);
        return mixed(body, edit_.star);
    }
    edit_.mesh.ring(owned.cell, owned.index, edit_.ring);
    return mixed(body, edit_.ring.cells);
}

int SurfaceCount::excess_at(std::uint32_t v) {
    edit_.mesh.star(v, star_);
    std::sort(star_.begin(), star_.end());
    across_.assign(star_.size(), {no_cell, no_cell, no_cell});
    for (std::size_t n = 0; n < star_.size(); ++n) {
        std::size_t k = 0;
        for (int i = 0; i < 4; ++i) {
            if (edit_.mesh.cell(star_[n])[i] == v) continue;
            const std::uint32_t c = edit_.mesh.neighbor(star_[n], i);
            if (c != no_cell)
                across_[n][k] = static_cast<std::uint32_t>(std::lower_bound(star_.begin(), star_.end(), c) -
                                                           star_.begin());
            ++k;
        }
    }
    int excess = 0;
    for (const Body& body : bodies_) {
        for (const bool inside : {true, false}) excess += std::max(0, components(body, inside) - 1);
    }
    return excess;
}

int SurfaceCount::components(const Body& body, bool inside) {
    seen_.assign(star_.size(), 0);
    int count = 0;
    for (std::uint32_t seed = 0; seed < star_.size(); ++seed) {
        if (seen_[seed] || holds(body, star_[seed]) != inside) continue;
        ++count;
        seen_[seed] = 1;
        stack_.assign(1, seed);
        while (!stack_.empty()) {
            const std::uint32_t n = stack_.back();
            stack_.pop_back();
            for (const std::uint32_t m : across_[n]) {
                if (m == no_cell || seen_[m] || holds(body, star_[m]) != inside) continue;
                seen_[m] = 1;
                stack_.push_back(m);
            }
        }
    }
    return count;
}

int SurfaceCount::characteristic(const Body& body) {
    int sum = 0;
    for (const std::uint32_t v : vertices_) {
        edit_.mesh.star(v, edit_.star);
        sum += mixed(body, edit_.star);
    }
    for (const Edge& edge : edges_) {
        edit_.mesh.ring(edge.cell, edge.index, edit_.ring);
        sum -= mixed(body, edit_.ring.cells);
    }
    for (const std::uint32_t c : cells_) {
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t n = edit_.mesh.neighbor(c, i);
            if (n == no_cell || holds(body, n) == holds(body, c)) continue;
            const bool twice = std::find(cells_.begin(), cells_.end(), n) != cells_.end();
            if (!twice || c < n) ++sum;
        }
    }
    return sum;
}

}  // namespace anatomesh
