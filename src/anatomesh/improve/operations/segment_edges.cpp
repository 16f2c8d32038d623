#include "anatomesh/improve/operations/segment_edges.h"

#include <algorithm>

#include "anatomesh/geom/numbers.h"
#include "anatomesh/improve/core/drawn_slices.h"
#include "anatomesh/mesh/check/topology.h"

namespace anatomesh {

namespace {

// The ends of the edges of all interfaces that start at a vertex; an edge comes once for each facet at it.
class InterfaceEdges {
  public:
    InterfaceEdges(const TetMesh& mesh, std::span<const std::uint32_t> neighbors)
        : start_(mesh.points.size() + 1, 0) {
        const std::vector<RegionFacet> facets = region_facets(mesh, neighbors);
        const auto vertex = [&](const RegionFacet& facet, std::size_t k) {
            return mesh.cells[facet.cell][static_cast<std::size_t>(facet_vertices[facet.index][k])];
        };
        for (const RegionFacet& facet : facets) {
            for (std::size_t k = 0; k < 3; ++k) start_[vertex(facet, k) + 1] += 2;
        }
        for (std::size_t v = 0; v < mesh.points.size(); ++v) start_[v + 1] += start_[v];
        std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
        ends_.resize(start_.back());
        for (const RegionFacet& facet : facets) {
            for (std::size_t k = 0; k < 3; ++k) {
                ends_[next[vertex(facet, k)]++] = vertex(facet, (k + 1) % 3);
                ends_[next[vertex(facet, k)]++] = vertex(facet, (k + 2) % 3);
            }
        }
    }
    std::span<const std::uint32_t> from(std::uint32_t v) const {
        return {ends_.data() + start_[v], start_[v + 1] - start_[v]};
    }

  private:
    std::vector<std::uint32_t> start_, ends_;
};

// Adds the chain of edges that starts at the end a of a segment, as far as it goes; says whether it ends at
// b.
bool follow(const TetMesh& mesh, const InterfaceEdges& edges, std::uint32_t a, std::uint32_t b,
            std::vector<VertexPair>& found) {
    const Vec3 start = mesh.points[a], way = mesh.points[b] - start;
    const double whole = squared_length(way);
    double reached = 0;
    for (std::uint32_t current = a; current != b;) {
        std::uint32_t next = no_cell;
        double next_reached = whole;
        for (const std::uint32_t end : edges.from(current)) {
            const Vec3 offset = mesh.points[end] - start;
            const double along = dot(offset, way);
            if (along <= reached || along > next_reached ||
                length(cross(offset, way)) > on_segment_share * whole)
                continue;
            next = end;
            next_reached = along;
        }
        if (next == no_cell) return false;
        found.push_back({std::min(current, next), std::max(current, next)});
        current = next;
        reached = next_reached;
    }
    return true;
}

}  // namespace

std::vector<VertexPair> edges_along(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                    std::span<const VertexPair> segments, std::vector<VertexPair>* missed) {
    const InterfaceEdges edges(mesh, neighbors);
    std::vector<VertexPair> found;
    for (const auto& [a, b] : segments) {
        if (follow(mesh, edges, a, b, found)) continue;
        follow(mesh, edges, b, a, found);
        if (missed) missed->push_back({a, b});
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

}  // namespace anatomesh
