#include "anatomesh/cut/nonmanifold_patch.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/edit/facets.h"

namespace anatomesh {

namespace {

// What the cells have as facets, each with its orientation seen from outside; those between two of them, which
// have both, cancel. Nothing where a facet belongs to more than two. Lowest vertex first, in order.
using OrientedFacet = std::pair<std::array<std::uint32_t, 3>, int>;
std::optional<std::vector<OrientedFacet>> oriented_boundary(const std::vector<Cell>& cells) {
    std::vector<OrientedFacet> facets;
    for (const Cell& c : cells) {
        for (std::array<std::uint32_t, 3> f : {std::array{c[1], c[2], c[3]}, std::array{c[0], c[3], c[2]},
                                               std::array{c[0], c[1], c[3]}, std::array{c[0], c[2], c[1]}}) {
            std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
            const int side = f[1] < f[2] ? 1 : -1;
            if (side < 0) std::swap(f[1], f[2]);
            facets.emplace_back(f, side);
        }
    }
    std::sort(facets.begin(), facets.end());
    std::vector<OrientedFacet> boundary;
    for (std::size_t n = 0; n < facets.size();) {
        std::size_t end = n + 1;
        while (end < facets.size() && facets[end].first == facets[n].first) ++end;
        if (end - n > 2) return std::nullopt;
        if (end - n == 1) boundary.push_back(facets[n]);
        if (end - n == 2 && facets[n].second == facets[n + 1].second) return std::nullopt;
        n = end;
    }
    return boundary;
}

}  // namespace

NonmanifoldPatch NonmanifoldPatch::take_from(TetMesh& mesh, const std::vector<std::uint32_t>& vertices,
                                             const ContourOwners& owners, RegionRegistry& registry) {
    NonmanifoldPatch patch{mesh.points, owners, registry, {}, {}, {}, {}};
    std::vector<std::uint8_t> reach(mesh.points.size(), 0);  // 1: one of them, 2: in such a star
    for (const std::uint32_t v : vertices) reach[v] = 1;
    for (int ring = 1; ring <= 2; ++ring) {
        std::vector<std::uint8_t> grown = reach;
        for (const Cell& cell : mesh.cells) {
            const bool touches =
                std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return reach[v] != 0; });
            if (!touches) continue;
            for (const std::uint32_t v : cell) {
                if (!grown[v]) grown[v] = static_cast<std::uint8_t>(ring + 1);
            }
        }
        reach = std::move(grown);
    }
    // Vertices within two steps have all their cells in the patch if the cells at them are taken.
    std::size_t kept = 0;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& cell = mesh.cells[c];
        if (std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return reach[v] != 0; })) {
            patch.cells.push_back(cell);
            patch.regions.push_back(mesh.regions[c]);
        } else {
            mesh.cells[kept] = cell;
            mesh.regions[kept++] = mesh.regions[c];
        }
    }
    mesh.cells.resize(kept);
    mesh.regions.resize(kept);
    for (std::uint32_t v = 0; v < reach.size(); ++v) {
        if (reach[v]) patch.watched.push_back(v);
    }
    patch.find_neighbors();
    return patch;
}

void NonmanifoldPatch::put_back(TetMesh& mesh) const {
    mesh.cells.insert(mesh.cells.end(), cells.begin(), cells.end());
    mesh.regions.insert(mesh.regions.end(), regions.begin(), regions.end());
}

void NonmanifoldPatch::find_neighbors() {
    const std::vector<std::uint32_t> flat = cell_neighbors(cells, points.size());
    neighbors.resize(cells.size());
    for (std::size_t c = 0; c < cells.size(); ++c) {
        for (int i = 0; i < 4; ++i) neighbors[c][i] = flat[4 * c + i];
    }
}

PatchStars::PatchStars(const NonmanifoldPatch& patch)
    : stars(patch.cells, patch.points.size()),
      analyzer(patch.cells, patch.neighbors, stars, patch.regions, patch.table(), patch.owners) {
    for (const std::uint32_t v : patch.watched) {
        if (analyzer.singularity_count(v) > 0) nonmanifold.push_back(v);
    }
}

void LabelledCells::add_prism(std::array<std::uint32_t, 3> a, std::array<std::uint32_t, 3> b, Region region) {
    // Turn the prism so that its smallest vertex is a[0].
    if (*std::min_element(b.begin(), b.end()) < *std::min_element(a.begin(), a.end())) std::swap(a, b);
    const std::ptrdiff_t turn = std::min_element(a.begin(), a.end()) - a.begin();
    std::rotate(a.begin(), a.begin() + turn, a.end());
    std::rotate(b.begin(), b.begin() + turn, b.end());
    // The two sides at a[0] are cut from a[0]; the third from its smallest vertex, which is a[1], a[2], b[1] or b[2].
    if (std::min(a[1], b[2]) < std::min(a[2], b[1])) {
        add({a[0], a[1], a[2], b[2]}, region);
        add({a[0], a[1], b[2], b[1]}, region);
    } else {
        add({a[0], a[1], a[2], b[1]}, region);
        add({a[0], b[1], a[2], b[2]}, region);
    }
    add({a[0], b[1], b[2], b[0]}, region);
}

bool PatchChange::touches(std::span<const std::uint32_t> cells) const {
    return std::any_of(cells.begin(), cells.end(), [&](std::uint32_t c) { return removed[c] != 0; });
}

void PatchChange::replace(NonmanifoldPatch& patch, std::span<const std::uint32_t> old,
                          const LabelledCells& cells, std::uint32_t first_new) {
    for (const std::uint32_t c : old) removed[c] = 1;
    added.cells.insert(added.cells.end(), cells.cells.begin(), cells.cells.end());
    added.regions.insert(added.regions.end(), cells.regions.begin(), cells.regions.end());
    points_added += patch.points.size() - first_new;
    cells_added += cells.cells.size() - old.size();
    for (std::uint32_t v = first_new; v < patch.points.size(); ++v) patch.watched.push_back(v);
}

void PatchChange::apply(NonmanifoldPatch& patch) const {
    std::size_t kept = 0;
    for (std::size_t c = 0; c < patch.cells.size(); ++c) {
        if (removed[c]) continue;
        patch.cells[kept] = patch.cells[c];
        patch.regions[kept++] = patch.regions[c];
    }
    patch.cells.resize(kept);
    patch.regions.resize(kept);
    patch.cells.insert(patch.cells.end(), added.cells.begin(), added.cells.end());
    patch.regions.insert(patch.regions.end(), added.regions.begin(), added.regions.end());
    patch.find_neighbors();
}

bool fits(const NonmanifoldPatch& patch, std::span<const std::uint32_t> removed, LabelledCells& added) {
    for (Cell& cell : added.cells) {
        const int sign = orient3d(patch.points[cell[0]], patch.points[cell[1]], patch.points[cell[2]],
                                  patch.points[cell[3]]);
        if (sign == 0) return false;
        if (sign < 0) std::swap(cell[2], cell[3]);
    }
    std::vector<Cell> before;
    for (const std::uint32_t c : removed) before.push_back(patch.cells[c]);
    const auto boundary = oriented_boundary(added.cells);
    return boundary && boundary == oriented_boundary(before);
}

}  // namespace anatomesh
