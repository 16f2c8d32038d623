#include "anatomesh/recover/cavity.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// Least dihedral angle of a good cell, 15 degrees. [1; 0 to 1; M 2026-11 fetal brain and crossing stacks]
constexpr double good_sine = 0.2588;
constexpr double good_ratio = 2;    // Radius-edge ratio of a good cell. [1; > 0.612; C clause 4]
constexpr double no_cell_here = 2;  // Stands for a facet that has the apex as a corner. [1; > 1; D]
// Rounding is far below such a share of the edges' product. [1; 0 to 1; D rounding of doubles]
constexpr double surely_positive = 1e-4;

MeshEdge edge_of(std::uint32_t a, std::uint32_t b) {
    return {std::min(a, b), std::max(a, b)};
}

}  // namespace

std::vector<std::uint32_t> take_with_undecided(EditMesh&& edited, TetMesh& mesh,
                                               std::vector<std::uint32_t>& neighbors) {
    mesh = std::move(edited).take(neighbors);
    std::vector<std::uint32_t> undecided;
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        if (mesh.regions[c] == undecided_region) undecided.push_back(c);
    }
    return undecided;
}

KeptEdges kept_edges(const std::vector<std::uint8_t>& fixed, const std::vector<Subsegment>& subsegments) {
    std::vector<std::uint8_t> kept = fixed;
    std::vector<MeshEdge> edges;
    for (const Subsegment& subsegment : subsegments) {
        kept.resize(std::max<std::size_t>(kept.size(), std::max(subsegment.a, subsegment.b) + 1), 0);
        kept[subsegment.a] = kept[subsegment.b] = 1;
        edges.push_back({subsegment.a, subsegment.b});
    }
    return {std::move(kept), std::move(edges)};
}

KeptEdges::KeptEdges(std::vector<std::uint8_t> fixed, std::vector<MeshEdge> edges)
    : fixed_(std::move(fixed)), edges_(std::move(edges)) {
    for (MeshEdge& e : edges_) e = edge_of(e[0], e[1]);
    std::sort(edges_.begin(), edges_.end());
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
}

bool KeptEdges::has(std::uint32_t a, std::uint32_t b) const {
    return fixed(a) && fixed(b) && std::binary_search(edges_.begin(), edges_.end(), edge_of(a, b));
}

void KeptEdges::fix(std::uint32_t v) {
    if (v >= fixed_.size()) fixed_.resize(v + 1, 0);
    fixed_[v] = 1;
}

void KeptEdges::add(std::uint32_t a, std::uint32_t b) {
    fix(a);
    fix(b);
    const auto place = std::lower_bound(edges_.begin(), edges_.end(), edge_of(a, b));
    if (place == edges_.end() || *place != edge_of(a, b)) edges_.insert(place, edge_of(a, b));
}

void Cavity::reset(std::span<const std::uint32_t> cells, Apex apex) {
    apex_ = apex;
    if (apex.vertex != no_cell) apex_.p = mesh_.point(apex.vertex);
    stamp_.resize(mesh_.cell_count(), 0);
    ++now_;
    cells_.assign(cells.begin(), cells.end());
    facets_.clear();
    for (const std::uint32_t c : cells_) stamp_[c] = now_;
    for (const std::uint32_t c : cells_) {
        for (int i = 0; i < 4; ++i) {
            if (!holds(mesh_.neighbor(c, i))) facets_.push_back(facet(c, i));
        }
    }
}

Cavity::Facet Cavity::facet(std::uint32_t c, int i) {
    const Cell& cell = mesh_.cell(c);
    const auto& f = facet_vertices[i];
    const std::array<std::uint32_t, 3> v{cell[f[0]], cell[f[1]], cell[f[2]]};
    const bool at_apex = std::find(v.begin(), v.end(), apex_.vertex) != v.end();
    return {v, mesh_.neighbor(c, i), at_apex ? no_cell_here : value(v)};
}

double Cavity::value(const std::array<std::uint32_t, 3>& v) const {
    const CellMeasures m = measure_cell(apex_.p, mesh_.point(v[0]), mesh_.point(v[1]), mesh_.point(v[2]));
    if (!(m.volume6 > 0)) return -1;
    return std::min({1.0, m.least_sine() / good_sine, good_ratio / std::sqrt(m.squared_ratio)});
}

bool Cavity::sees(const Facet& f) const {
    return f.value > surely_positive ||
           orient3d(apex_.p, mesh_.point(f.v[0]), mesh_.point(f.v[1]), mesh_.point(f.v[2])) > 0;
}

void Cavity::take(std::uint32_t c) {
    std::erase_if(facets_, [&](const Facet& f) { return f.beyond == c; });
    stamp_[c] = now_;
    cells_.push_back(c);
    for (int i = 0; i < 4; ++i) {
        if (!holds(mesh_.neighbor(c, i))) facets_.push_back(facet(c, i));
    }
}

bool Cavity::see_all() {
    for (std::size_t n = 0; n < facets_.size(); ++n) {
        if (sees(facets_[n])) continue;
        const std::uint32_t beyond = facets_[n].beyond;
        if (beyond == no_cell || cells_.size() == most_cells) return false;
        take(beyond);
        n = static_cast<std::size_t>(-1);
    }
    return true;
}

// The cell behind the facet, if its other facets all make better cells, and nothing kept goes.
bool Cavity::take_better(const Facet& f) {
    if (f.beyond == no_cell || cells_.size() == most_cells) return false;
    for (int i = 0; i < 4; ++i) {
        if (holds(mesh_.neighbor(f.beyond, i))) continue;
        const Facet other = facet(f.beyond, i);
        if (!(other.value > f.value) || !sees(other)) return false;
    }
    const std::vector<Facet> before = facets_;
    take(f.beyond);
    if (keeps({&cells_.back(), 1})) return true;
    facets_ = before;
    stamp_[f.beyond] = 0;
    cells_.pop_back();
    return false;
}

bool Cavity::open() {
    if (cells_.size() > most_cells || !see_all() || !keeps(cells_)) return false;
    for (std::size_t n = 0; n < facets_.size(); ++n) {
        const Facet f = facets_[n];
        if (f.value >= 1 || !take_better(f)) continue;
        n = static_cast<std::size_t>(-1);
    }
    return true;
}

// Whether the kept edges and vertices of these cells, which are in the cavity, stay.
bool Cavity::keeps(std::span<const std::uint32_t> cells) const {
    const auto on_rim = [&](std::uint32_t a, std::uint32_t b) {
        return std::any_of(facets_.begin(), facets_.end(), [&](const Facet& f) {
            return std::find(f.v.begin(), f.v.end(), a) != f.v.end() &&
                   std::find(f.v.begin(), f.v.end(), b) != f.v.end();
        });
    };
    for (const std::uint32_t c : cells) {
        const Cell& cell = mesh_.cell(c);
        for (const std::uint32_t v : cell) {
            if (kept_.fixed(v) && v != apex_.vertex && !on_rim(v, v)) return false;
        }
        for (const auto& [i, j] : cell_edges) {
            // The apex is joined to every vertex of the rim.
            if (cell[i] == apex_.vertex || cell[j] == apex_.vertex) continue;
            if (kept_.has(cell[i], cell[j]) && !on_rim(cell[i], cell[j])) return false;
        }
    }
    return true;
}

double Cavity::worst() const {
    double worst = 1;
    for (const Facet& f : facets_) worst = std::min(worst, f.value);
    return worst;
}

std::uint32_t Cavity::fill() {
    const std::uint32_t v = apex_.vertex == no_cell ? mesh_.add_point(apex_.p) : apex_.vertex;
    std::vector<Cell> cells;
    for (const Facet& f : facets_) {
        if (f.value != no_cell_here) cells.push_back({v, f.v[0], f.v[1], f.v[2]});
    }
    const std::vector<Region> regions(cells.size(), undecided_region);
    mesh_.replace(cells_, cells, regions, slots_);
    return v;
}

}  // namespace anatomesh
