#include "anatomesh/improve/core/hole.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

Hole::Hole(EditContext& edit, const EdgeRing& ring) : edit_(edit) {
    for (const std::uint32_t c : ring.cells) {
        cells_.push_back(c);
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t opposite = edit.mesh.cell(c)[i];
            if (opposite == ring.a || opposite == ring.b) facets_.push_back(facet(c, i));
        }
    }
}

Hole::Hole(EditContext& edit, std::vector<std::uint32_t> cells, std::span<const CellFacet> given)
    : edit_(edit), cells_(std::move(cells)) {
    for (const std::uint32_t c : cells_) {
        for (int i = 0; i < 4; ++i) {
            if (holds(edit.mesh.neighbor(c, i))) continue;
            facets_.push_back(facet(c, i));
            if (std::find(given.begin(), given.end(), CellFacet{c, i}) == given.end()) continue;
            facets_.back().region = edit.mesh.region(facets_.back().beyond);
            facets_.back().beyond = no_cell;
        }
    }
}

Vec3 Hole::centre() const {
    Vec3 sum{};
    for (const Facet& f : facets_) {
        for (const std::uint32_t v : f.v) sum = sum + edit_.mesh.point(v);
    }
    return (1.0 / (3.0 * static_cast<double>(facets_.size()))) * sum;
}

Hole::Facet Hole::facet(std::uint32_t c, int i) const {
    const Cell& cell = edit_.mesh.cell(c);
    const auto& f = facet_vertices[i];
    return {{cell[f[0]], cell[f[1]], cell[f[2]]}, edit_.mesh.region(c), edit_.mesh.neighbor(c, i)};
}

// The least sine of the cell that the facet makes with p, as if it was lower where the ratio is above the
// bound.
double Hole::value(const Facet& f, Vec3 p) const {
    const CellMeasures cell =
        measure_cell(p, edit_.mesh.point(f.v[0]), edit_.mesh.point(f.v[1]), edit_.mesh.point(f.v[2]));
    const double sine = cell.least_sine();
    if (cell.squared_ratio <= squared_ratio_) return sine;
    return std::min(sine, edit_.goal * std::sqrt(squared_ratio_ / cell.squared_ratio));
}

// The cells as LocalStar is to see them; the least sine with the vertex at p.
double Hole::begin_round(Vec3 p, const QualityThreshold& threshold) {
    edit_.scratch.local.reset(edit_.rule.needed_outside_sine(threshold), squared_ratio_);
    double least = 1;
    for (const Facet& f : facets_) {
        const Vec3 a = edit_.mesh.point(f.v[0]), b = edit_.mesh.point(f.v[1]), c = edit_.mesh.point(f.v[2]);
        const bool counts = edit_.counts(f.region, f.v);
        edit_.scratch.local.add(a, b, c, counts);
        if (counts) least = std::min(least, least_sine(p, a, b, c));
    }
    return least;
}

// Takes in the cells behind facets that make a bad cell with p, where their own facets make better ones.
bool Hole::grow(Vec3 p) {
    bool grown = false;
    for (std::size_t n = 0; n < facets_.size() && facets_.size() < most_facets; ++n) {
        const Facet f = facets_[n];
        if (f.beyond == no_cell || edit_.mesh.region(f.beyond) != f.region) continue;
        const double own = value(f, p);
        if (own >= edit_.goal || !take(f.beyond, p, own)) continue;
        grown = true;
        n = static_cast<std::size_t>(-1);
    }
    return grown;
}

bool Hole::take(std::uint32_t c, Vec3 p, double own) {
    if (!may_take(c)) return false;
    for (int i = 0; i < 4; ++i) {
        if (!holds(edit_.mesh.neighbor(c, i)) && !(value(facet(c, i), p) > own)) return false;
    }
    take(c);
    return true;
}

// Facets of an interface stay.
bool Hole::may_take(std::uint32_t c) const {
    return std::none_of(facets_.begin(), facets_.end(),
                        [&](const Facet& f) { return f.beyond == c && f.region != edit_.mesh.region(c); });
}

// The facets between the cell and the hole go.
void Hole::take(std::uint32_t c) {
    std::erase_if(facets_, [&](const Facet& f) { return f.beyond == c; });
    for (int i = 0; i < 4; ++i) {
        if (!holds(edit_.mesh.neighbor(c, i))) facets_.push_back(facet(c, i));
    }
    cells_.push_back(c);
}

bool Hole::add(const EdgeRing& ring) {
    if (!ring.closed) return false;
    const Region region = edit_.mesh.region(ring.cells.front());
    for (const std::uint32_t c : ring.cells) {
        if (edit_.mesh.region(c) != region) return false;
        if (holds(c)) continue;
        if (!may_take(c)) return false;
        take(c);
    }
    return true;
}

// Vertices that would lose all their cells must be free and off the interfaces.
bool Hole::keeps_vertices() const {
    std::vector<std::uint32_t> rim;
    for (const Facet& f : facets_) rim.insert(rim.end(), f.v.begin(), f.v.end());
    std::sort(rim.begin(), rim.end());
    for (const std::uint32_t c : cells_) {
        for (const std::uint32_t v : edit_.mesh.cell(c)) {
            if (!std::binary_search(rim.begin(), rim.end(), v) &&
                (edit_.constraints.fixed(v) || edit_.mesh.vertex_on_interface(v))) {
                return false;
            }
        }
    }
    return true;
}

bool Hole::commit(Vec3 p) {
    const std::uint32_t v = edit_.add_point(p);
    edit_.scratch.cells.clear();
    edit_.scratch.regions.clear();
    for (const Facet& f : facets_) {
        edit_.scratch.cells.push_back({v, f.v[0], f.v[1], f.v[2]});
        edit_.scratch.regions.push_back(f.region);
    }
    return edit_.commit(cells_, edit_.scratch.cells, edit_.scratch.regions);
}

}  // namespace anatomesh
