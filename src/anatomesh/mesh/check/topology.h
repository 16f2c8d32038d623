// Topology of a tetrahedral mesh and of the surfaces of its structures.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/model/surface_mesh.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// A facet between cells of two regions, as one of the cell in the region with the larger number.
struct RegionFacet {
    std::uint32_t cell, index;  // the facet of the cell, opposite its vertex `index`
    std::uint32_t other;        // the cell beyond; no_cell outside a mesh that has no cells outside
};

// All of them, by cell and index. `neighbors`: as cell_neighbors() gives them. Requires: the mesh has no
// cells outside, or has them round every interface. Complexity: linear in the cells.
std::vector<RegionFacet> region_facets(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                       int threads = 1);

// Counts of a triangle set. It is a closed, oriented 2-manifold when the last four counts are all 0.
struct SurfaceTopology {
    std::uint64_t triangles = 0, edges = 0, vertices = 0;
    std::uint32_t components = 0;  // shells: pieces joined across edges
    std::int64_t euler = 0;        // vertices - edges + triangles
    std::int64_t genus = 0;        // components - euler / 2, summed over components; for closed surfaces
    std::uint64_t open_edges = 0;  // in one triangle
    std::uint64_t nonmanifold_edges = 0;     // in more than two
    std::uint64_t nonmanifold_vertices = 0;  // whose triangles form more than one fan
    std::uint64_t misoriented_edges = 0;     // in two triangles that run along it the same way

    bool closed_manifold() const {
        return open_edges == 0 && nonmanifold_edges == 0 && nonmanifold_vertices == 0 &&
               misoriented_edges == 0;
    }
};

// Topology of a triangle set. Complexity: O(n log n) at worst, linear for bounded vertex degree; memory also
// grows with the largest index. `shell_of`, where given: the number of every triangle's shell, from 0 in the
// order of their first triangles.
SurfaceTopology surface_topology(std::span<const Triangle> triangles,
                                 std::vector<std::uint32_t>* shell_of = nullptr);

// Outward boundary triangles of one structure: of the union of all regions that contain it. In the order of
// the cells that they bound. The second form takes the neighbors of mesh.cells where they are known already.
std::vector<Triangle> structure_surface(const TetMesh& mesh, const RegionTable& regions,
                                        std::uint32_t structure);
std::vector<Triangle> structure_surface(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                        const RegionTable& regions, std::uint32_t structure, int threads = 1);

// Every interface between two regions (0 = outside included), each facet once, with its two sides: the inner
// side is the region of the larger number. Triangles come in the order of their inner cells; points are the
// mesh's points that the surface uses, in their order.
SurfaceMesh extract_interfaces(const TetMesh& mesh);
SurfaceMesh extract_interfaces(const TetMesh& mesh, std::span<const std::uint32_t> neighbors);

// Number of facet-connected pieces of the cells whose region contains the structure.
std::uint32_t structure_pieces(const TetMesh& mesh, const RegionTable& regions, std::uint32_t structure);
std::uint32_t structure_pieces(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                               const RegionTable& regions, std::uint32_t structure);

}  // namespace anatomesh
