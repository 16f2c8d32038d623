#include "anatomesh/cut/lift_facets.h"

#include <algorithm>
#include <cassert>
#include <optional>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/quality.h"

namespace anatomesh {

namespace {

bool positive(const std::vector<Vec3>& points, const Cell& c) {
    return orient3d(points[c[0]], points[c[1]], points[c[2]], points[c[3]]) > 0;
}

Cell with(Cell cell, std::size_t index, std::uint32_t vertex) {
    cell[index] = vertex;
    return cell;
}

// The facet of cell c that lies in a slice between regions of which the cell's has a structure that is not
// drawn there, and the other one what is.
class RestingFacets {
  public:
    RestingFacets(const TetMesh& mesh, const std::vector<std::uint32_t>& neighbors, const RegionTable& table,
                  std::span<const std::uint32_t> slice_of, const StructureField& field)
        : mesh_(mesh), neighbors_(neighbors), table_(table), slice_of_(slice_of), field_(field) {}

    // The cells that may have one, rising.
    std::vector<std::uint32_t> candidates(int threads) const {
        return parallel_collect<std::uint32_t>(
            mesh_.cells.size(), 16384, threads,
            [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& cells) {
                for (std::size_t c = first; c < last; ++c) {
                    bool any = false;
                    for (std::size_t i = 0; i < 4 && !any; ++i) any = in_slice(mesh_.cells[c], i);
                    if (any) cells.push_back(static_cast<std::uint32_t>(c));
                }
            });
    }

    std::optional<std::size_t> of(std::size_t c) {
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t other = neighbors_[4 * c + i];
            if (other == no_cell || mesh_.regions[other] == mesh_.regions[c] || !in_slice(mesh_.cells[c], i))
                continue;
            if (rests(c, i, mesh_.regions[other])) return i;
        }
        return std::nullopt;
    }

  private:
    bool in_slice(const Cell& cell, std::size_t i) const {
        const auto slice = [&](int corner) { return slice_of_[cell[facet_vertices[i][corner]]]; };
        return slice(0) != no_slice && slice(1) == slice(0) && slice(2) == slice(0);
    }

    bool rests(std::size_t c, std::size_t i, Region across) {
        Vec3 middle{};
        for (const int n : facet_vertices[i]) middle = middle + (1.0 / 3) * mesh_.points[mesh_.cells[c][n]];
        field_.members(middle, drawn_);
        const std::vector<std::uint32_t>& here = table_.members[mesh_.regions[c]];
        return table_.members[across] == drawn_ &&
               !std::includes(drawn_.begin(), drawn_.end(), here.begin(), here.end());
    }

    const TetMesh& mesh_;
    const std::vector<std::uint32_t>& neighbors_;
    const RegionTable& table_;
    std::span<const std::uint32_t> slice_of_;
    const StructureField& field_;
    std::vector<std::uint32_t> drawn_;
};

double radius_edge(const std::vector<Vec3>& points, const Cell& c) {
    return radius_edge_ratio(points[c[0]], points[c[1]], points[c[2]], points[c[3]]);
}

// Appends a point from which cell c may be split over its facet i.
bool add_apex(TetMesh& mesh, std::size_t c, std::size_t i, Region across, const LiftOptions& options) {
    const Cell& cell = mesh.cells[c];
    const auto apex = static_cast<std::uint32_t>(mesh.points.size());
    Vec3 middle{};
    for (const int n : facet_vertices[i]) middle = middle + (1.0 / 3) * mesh.points[cell[n]];
    const double bound = std::max(options.max_radius_edge, radius_edge(mesh.points, cell));
    for (int step = 1; step <= 3 && step * options.height < 1; ++step) {
        mesh.points.push_back(middle + step * options.height * (mesh.points[cell[i]] - middle));
        bool good = true;
        for (std::size_t j = 0; j < 4; ++j) {
            const Cell part = with(cell, j, apex);
            good = good && positive(mesh.points, part) &&
                   ((j == i && across == 0) || radius_edge(mesh.points, part) <= bound);
        }
        if (good) return true;
        mesh.points.pop_back();
    }
    return false;
}

// Splits cell c over its facet i from the last point; the part on the facet takes that number and the region
// across.
void split_over(TetMesh& mesh, std::vector<std::uint32_t>& neighbors, std::size_t c, std::size_t i) {
    const Cell cell = mesh.cells[c];
    const auto apex = static_cast<std::uint32_t>(mesh.points.size() - 1);
    std::array<std::uint32_t, 4> number{};  // of the part without vertex j
    auto next = static_cast<std::uint32_t>(mesh.cells.size());
    for (std::size_t j = 0; j < 4; ++j) number[j] = j == i ? static_cast<std::uint32_t>(c) : next++;
    std::array<std::uint32_t, 4> beyond{};
    for (std::size_t j = 0; j < 4; ++j) beyond[j] = neighbors[4 * c + j];
    const Region region = mesh.regions[c];
    mesh.regions[c] = mesh.regions[beyond[i]];
    mesh.cells[c] = with(cell, i, apex);
    for (std::size_t j = 0; j < 4; ++j) {
        if (j != i) {
            mesh.cells.push_back(with(cell, j, apex));
            mesh.regions.push_back(region);
            neighbors.resize(neighbors.size() + 4);
            for (std::size_t k = 0; beyond[j] != no_cell && k < 4; ++k) {
                std::uint32_t& back = neighbors[4 * std::size_t{beyond[j]} + k];
                if (back == c) back = number[j];
            }
        }
        // Across from the new vertex lies what was there before, across from the others the other parts.
        for (std::size_t k = 0; k < 4; ++k)
            neighbors[4 * std::size_t{number[j]} + k] = k == j ? beyond[j] : number[k];
    }
}

}  // namespace

LiftStats lift_facets(TetMesh& mesh, std::vector<std::uint32_t>& neighbors, const RegionTable& table,
                      std::span<const std::uint32_t> slice_of, const StructureField& field,
                      const LiftOptions& options, int threads) {
    assert(slice_of.size() == mesh.points.size() && neighbors.size() == 4 * mesh.cells.size());
    assert(options.height > 0 && options.height < 1);
    LiftStats stats;
    RestingFacets resting(mesh, neighbors, table, slice_of, field);
    // Lifting a facet of one of them leaves the vertices of the others.
    for (const std::uint32_t c : resting.candidates(threads)) {
        const std::optional<std::size_t> facet = resting.of(c);
        if (!facet) continue;
        if (add_apex(mesh, c, *facet, mesh.regions[neighbors[4 * c + *facet]], options)) {
            split_over(mesh, neighbors, c, *facet);
            ++stats.facets_lifted;
        } else {
            ++stats.facets_left;
        }
    }
    return stats;
}

}  // namespace anatomesh
