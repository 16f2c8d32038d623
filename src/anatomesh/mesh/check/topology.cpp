#include "anatomesh/mesh/check/topology.h"

#include <algorithm>
#include <cassert>

#include "anatomesh/base/disjoint_sets.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/buckets.h"

namespace anatomesh {

namespace {

// A thread takes so many cells at a time, enough to hide the cost of handing them out. [cells; >= 1; B]
constexpr std::size_t grain = 16384;

// The edge from corner e to corner e + 1 of triangle t has id 3 t + e.
std::uint32_t next_corner(std::uint32_t corner) {
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

std::vector<std::uint8_t> region_flags(const RegionTable& regions, std::uint32_t structure) {
    std::vector<std::uint8_t> flags(regions.members.size(), 0);
    for (std::size_t r = 0; r < flags.size(); ++r)
        flags[r] = regions.contains(static_cast<Region>(r), structure);
    return flags;
}

// What surface_topology() learns from the edges; corners (3 t + i) are joined round their vertex.
struct EdgeCensus {
    const std::vector<std::uint32_t>& corner_vertex;
    DisjointSets fans;
    DisjointSets shells;
    SurfaceTopology& topology;

    // The triangles at one edge: entries [first, last) of a bucket.
    void add_edge(const Entry* first, const Entry* last) {
        ++topology.edges;
        const auto count = last - first;
        if (count == 1) ++topology.open_edges;
        if (count > 2) ++topology.nonmanifold_edges;
        if (count == 2 && corner_vertex[first[0].id] == corner_vertex[first[1].id])
            ++topology.misoriented_edges;
        for (const Entry* other = first + 1; other < last; ++other) {
            std::uint32_t a = first->id, b = other->id;
            shells.join(a / 3, b / 3);
            std::uint32_t a_end = next_corner(a), b_end = next_corner(b);
            if (corner_vertex[a] != corner_vertex[b]) std::swap(b, b_end);
            fans.join(a, b);
            fans.join(a_end, b_end);
        }
    }
};

// Vertices whose corners fall into more than one fan, and the number of vertices.
void count_vertices(const std::vector<std::uint32_t>& corner_vertex, std::size_t vertex_count,
                    DisjointSets& fans, SurfaceTopology& topology) {
    // It stands for a vertex without a fan so far. [index; 2^32 - 1; D]
    constexpr std::uint32_t unseen = 0xFFFFFFFFu;
    // It stands for a vertex with more than one fan, which is counted once. [index; 2^32 - 2; D]
    constexpr std::uint32_t several = 0xFFFFFFFEu;
    std::vector<std::uint32_t> fan_of(vertex_count, unseen);
    for (std::uint32_t corner = 0; corner < corner_vertex.size(); ++corner) {
        std::uint32_t& fan = fan_of[corner_vertex[corner]];
        const std::uint32_t root = fans.root(corner);
        if (fan == unseen) {
            ++topology.vertices;
            fan = root;
        } else if (fan != several && fan != root) {
            ++topology.nonmanifold_vertices;
            fan = several;
        }
    }
}

}  // namespace

std::vector<RegionFacet> region_facets(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                       int threads) {
    assert(neighbors.size() == 4 * mesh.cells.size());
    const bool ends = std::find(mesh.regions.begin(), mesh.regions.end(), Region{0}) == mesh.regions.end();
    return parallel_collect<RegionFacet>(
        neighbors.size(), 4 * grain, threads,
        [&](std::size_t first, std::size_t last, std::vector<RegionFacet>& facets) {
            for (std::size_t n = first; n < last; ++n) {
                const auto facet = static_cast<std::uint32_t>(n);
                const std::uint32_t c = facet / 4, other = neighbors[facet];
                if (other == no_cell ? ends : mesh.regions[c] > mesh.regions[other])
                    facets.push_back({c, facet % 4, other});
            }
        });
}

SurfaceTopology surface_topology(std::span<const Triangle> triangles, std::vector<std::uint32_t>* shell_of) {
    assert(triangles.size() < 0xFFFFFFFEu / 3);
    std::vector<std::uint32_t> corner_vertex;
    corner_vertex.reserve(3 * triangles.size());
    std::size_t vertex_count = 0;
    for (const Triangle& triangle : triangles) {
        for (const std::uint32_t vertex : triangle) {
            corner_vertex.push_back(vertex);
            vertex_count = std::max<std::size_t>(vertex_count, std::size_t{vertex} + 1);
        }
    }
    const Buckets buckets = fill_buckets(vertex_count, [&](const auto& emit) {
        for (std::uint32_t corner = 0; corner < corner_vertex.size(); ++corner) {
            const std::uint32_t a = corner_vertex[corner], b = corner_vertex[next_corner(corner)];
            emit(std::min(a, b), std::max(a, b), corner);
        }
    });

    SurfaceTopology topology;
    topology.triangles = triangles.size();
    EdgeCensus census{corner_vertex, DisjointSets(corner_vertex.size()), DisjointSets(triangles.size()),
                      topology};
    for (std::size_t v = 0; v < vertex_count; ++v) {
        const Entry* first = buckets.entries.data() + buckets.start[v];
        const Entry* const end = buckets.entries.data() + buckets.start[v + 1];
        while (first < end) {
            const Entry* last = first + 1;
            while (last < end && last->key == first->key) ++last;
            census.add_edge(first, last);
            first = last;
        }
    }
    count_vertices(corner_vertex, vertex_count, census.fans, topology);
    if (shell_of) shell_of->resize(triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const std::uint32_t root = census.shells.root(t);  // its smallest triangle
        if (shell_of) (*shell_of)[t] = root == t ? topology.components : (*shell_of)[root];
        topology.components += root == t;
    }
    topology.euler = static_cast<std::int64_t>(topology.vertices) -
                     static_cast<std::int64_t>(topology.edges) +
                     static_cast<std::int64_t>(topology.triangles);
    topology.genus = static_cast<std::int64_t>(topology.components) - topology.euler / 2;
    return topology;
}

std::vector<Triangle> structure_surface(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                        const RegionTable& regions, std::uint32_t structure, int threads) {
    assert(neighbors.size() == 4 * mesh.cells.size());
    const std::vector<std::uint8_t> inside = region_flags(regions, structure);
    return parallel_collect<Triangle>(
        mesh.cells.size(), grain, threads,
        [&](std::size_t first, std::size_t last, std::vector<Triangle>& surface) {
            for (std::size_t c = first; c < last; ++c) {
                if (!inside[mesh.regions[c]]) continue;
                for (std::size_t i = 0; i < 4; ++i) {
                    const std::uint32_t other = neighbors[4 * c + i];
                    if (other == no_cell || !inside[mesh.regions[other]])
                        surface.push_back(facet_of(mesh.cells[c], i));
                }
            }
        });
}

std::vector<Triangle> structure_surface(const TetMesh& mesh, const RegionTable& regions,
                                        std::uint32_t structure) {
    return structure_surface(mesh, cell_neighbors(mesh.cells, mesh.points.size()), regions, structure);
}

SurfaceMesh extract_interfaces(const TetMesh& mesh, std::span<const std::uint32_t> neighbors) {
    assert(neighbors.size() == 4 * mesh.cells.size());
    SurfaceMesh surface;
    std::vector<std::uint32_t> new_index(mesh.points.size(), 0);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t other = neighbors[4 * c + i];
            const Region outer = other == no_cell ? Region{0} : mesh.regions[other];
            if (mesh.regions[c] <= outer) continue;
            surface.triangles.push_back(facet_of(mesh.cells[c], i));
            surface.sides.push_back({mesh.regions[c], outer});
            for (const std::uint32_t v : surface.triangles.back()) new_index[v] = 1;
        }
    }
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        if (!new_index[v]) continue;
        new_index[v] = static_cast<std::uint32_t>(surface.points.size());
        surface.points.push_back(mesh.points[v]);
    }
    for (Triangle& triangle : surface.triangles) {
        for (std::uint32_t& v : triangle) v = new_index[v];
    }
    return surface;
}

SurfaceMesh extract_interfaces(const TetMesh& mesh) {
    return extract_interfaces(mesh, cell_neighbors(mesh.cells, mesh.points.size()));
}

std::uint32_t structure_pieces(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                               const RegionTable& regions, std::uint32_t structure) {
    assert(neighbors.size() == 4 * mesh.cells.size());
    const std::vector<std::uint8_t> inside = region_flags(regions, structure);
    DisjointSets pieces(mesh.cells.size());
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        if (!inside[mesh.regions[c]]) continue;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t other = neighbors[4 * c + i];
            if (other != no_cell && other > c && inside[mesh.regions[other]]) pieces.join(c, other);
        }
    }
    std::uint32_t count = 0;
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        count += inside[mesh.regions[c]] && pieces.root(c) == c;
    }
    return count;
}

std::uint32_t structure_pieces(const TetMesh& mesh, const RegionTable& regions, std::uint32_t structure) {
    return structure_pieces(mesh, cell_neighbors(mesh.cells, mesh.points.size()), regions, structure);
}

}  // namespace anatomesh
