#include "anatomesh/mesh/edit/drop_outside.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/edit/facets.h"

namespace anatomesh {

namespace {

// A thread takes so many cells at a time, enough to hide the cost of handing them out. [cells; >= 1; B]
constexpr std::size_t grain = 65536;

}  // namespace

std::vector<std::uint32_t> drop_outside(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                        unsigned threads) {
    assert(neighbors.size() == 4 * mesh.cells.size() && mesh.regions.size() == mesh.cells.size());
    std::vector<std::uint32_t> vertex(mesh.points.size(), no_cell), number(mesh.cells.size(), no_cell);
    std::uint32_t kept = 0;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        if (mesh.regions[c] == 0) continue;
        for (const std::uint32_t v : mesh.cells[c]) vertex[v] = 0;
        for (std::size_t i = 0; i < 4; ++i) neighbors[4 * std::size_t{kept} + i] = neighbors[4 * c + i];
        mesh.cells[kept] = mesh.cells[c];
        mesh.regions[kept] = mesh.regions[c];
        number[c] = kept++;
    }
    mesh.cells.resize(kept);
    mesh.regions.resize(kept);
    neighbors.resize(4 * std::size_t{kept});
    parallel_for(neighbors.size(), grain, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n) {
            if (neighbors[n] != no_cell) neighbors[n] = number[neighbors[n]];
        }
    });
    assert(neighbors == cell_neighbors(mesh.cells, mesh.points.size()));
    std::uint32_t used = 0;
    for (std::size_t v = 0; v < vertex.size(); ++v) {
        if (vertex[v] == no_cell) continue;
        mesh.points[used] = mesh.points[v];
        vertex[v] = used++;
    }
    mesh.points.resize(used);
    parallel_for(mesh.cells.size(), grain, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) {
            for (std::uint32_t& v : mesh.cells[c]) v = vertex[v];
        }
    });
    return vertex;
}

void compact_regions(TetMesh& mesh, RegionTable& table) {
    std::vector<std::uint8_t> used(table.members.size(), 0);
    for (const Region region : mesh.regions) used[region] = 1;
    std::vector<Region> order;
    for (std::size_t r = 1; r < used.size(); ++r) {
        if (used[r]) order.push_back(static_cast<Region>(r));
    }
    std::sort(order.begin(), order.end(), [&](Region a, Region b) {
        const auto &x = table.members[a], &y = table.members[b];
        return x.size() != y.size() ? x.size() < y.size() : x < y;
    });
    RegionTable compact;
    std::vector<Region> number(used.size(), 0);
    for (const Region region : order) {
        number[region] = static_cast<Region>(compact.members.size());
        compact.members.push_back(table.members[region]);
    }
    for (Region& region : mesh.regions) region = number[region];
    table = std::move(compact);
}

}  // namespace anatomesh
