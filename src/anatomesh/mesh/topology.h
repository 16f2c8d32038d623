// Topology of a tetrahedral mesh and of the surfaces of its structures.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/surface_mesh.h"
#include "anatomesh/mesh/tet_mesh.h"

namespace anatomesh {

// neighbors[4 c + i] is the cell across facet i of cell c, no_cell on the boundary of the mesh.
// Requires: no facet in more than two cells. Complexity: O(cells), by sorting facets in buckets of their smallest vertex.
std::vector<std::uint32_t> cell_neighbors(std::span<const Cell> cells, std::size_t point_count);

// The surface of a set of cells, given per cell as a flag (0 or 1): facets with exactly one cell of the set on
// them, outward. Also counts facets with more than two cells of the mesh (must be 0 in a valid mesh).
struct SurfaceTopology {
    std::uint64_t triangles = 0, edges = 0, vertices = 0;
    std::uint32_t components = 0;          // shells, joined across edges
    std::uint64_t open_edges = 0, nonmanifold_edges = 0, nonmanifold_vertices = 0;
    std::int64_t euler = 0;
    std::int64_t genus = 0;                // components - euler / 2, summed over components; for closed surfaces
};

// Topology of a triangle set. Complexity: O(n log n).
SurfaceTopology surface_topology(std::span<const Triangle> triangles);

// Outward boundary triangles of one structure: of the union of all regions that contain it.
std::vector<Triangle> structure_surface(const TetMesh& mesh, const RegionTable& regions, std::uint32_t structure);

// Every interface between two regions (0 = outside included), each facet once, with its two sides.
// Triangles come in the order of their cells; points are the mesh's points that the surface uses, in their order.
SurfaceMesh extract_interfaces(const TetMesh& mesh);

// Number of facet-connected pieces of the cells whose region contains the structure.
std::uint32_t structure_pieces(const TetMesh& mesh, const RegionTable& regions, std::uint32_t structure);

}  // namespace anatomesh
