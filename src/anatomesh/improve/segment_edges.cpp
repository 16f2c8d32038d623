#include <algorithm>

#include "anatomesh/improve/improve_dihedrals.h"
#include "anatomesh/mesh/topology.h"

namespace anatomesh {

namespace {

constexpr double off_line = 1e-6;  // of a chain's vertices from the segment, in its lengths

// Edges of all interfaces in both directions, sorted.
std::vector<VertexPair> interface_edges(const TetMesh& mesh) {
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    std::vector<VertexPair> edges;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t n = neighbors[4 * c + i];
            if (mesh.regions[c] <= (n == no_cell ? Region{0} : mesh.regions[n])) continue;
            const auto& f = facet_vertices[i];
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = mesh.cells[c][f[k]], b = mesh.cells[c][f[(k + 1) % 3]];
                edges.push_back({a, b});
                edges.push_back({b, a});
            }
        }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
}

}  // namespace

std::vector<VertexPair> edges_along(const TetMesh& mesh, std::span<const VertexPair> segments) {
    const std::vector<VertexPair> edges = interface_edges(mesh);
    std::vector<VertexPair> found, chain;
    for (const auto& [a, b] : segments) {
        const Vec3 start = mesh.points[a], way = mesh.points[b] - start;
        const double whole = squared_length(way);
        chain.clear();
        double reached = 0;
        for (std::uint32_t current = a; current != b;) {
            std::uint32_t next = no_cell;
            double next_reached = whole;
            auto edge = std::lower_bound(edges.begin(), edges.end(), VertexPair{current, 0});
            for (; edge != edges.end() && (*edge)[0] == current; ++edge) {
                const Vec3 offset = mesh.points[(*edge)[1]] - start;
                const double along = dot(offset, way);
                if (along <= reached || along > next_reached || length(cross(offset, way)) > off_line * whole)
                    continue;
                next = (*edge)[1];
                next_reached = along;
            }
            if (next == no_cell) {
                chain.clear();
                break;
            }
            chain.push_back({std::min(current, next), std::max(current, next)});
            current = next;
            reached = next_reached;
        }
        found.insert(found.end(), chain.begin(), chain.end());
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

}  // namespace anatomesh
