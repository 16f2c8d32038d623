// Whether the contours are in the model: their vertices, bit for bit, and their segments as chains of edges.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/contour/contour_set.h"
#include "anatomesh/mesh/surface_mesh.h"
#include "anatomesh/mesh/tet_mesh.h"

namespace anatomesh {

struct StructureFidelity {
    std::uint64_t vertices = 0, vertices_on_surface = 0;
    std::uint64_t segments = 0, segments_on_surface = 0;
};

struct ContourFidelity {
    std::vector<StructureFidelity> structures;  // by structure of the contour set
    // Mesh vertex of every point of the contour set, on the surface of its structure; no_cell where there is
    // none.
    std::vector<std::uint32_t> vertex_of;
};

// `surfaces[s]` is the surface of the contour set's structure s as triangles of `points`.
// A vertex is on the surface when a surface vertex has its three coordinates as doubles. A segment is when a
// chain of surface edges leads along it, none of whose vertices is further from it than 1e-6 of its length
// and 1e-12 of the coordinates' size. Complexity: O(n log n).
ContourFidelity contour_fidelity(std::span<const Vec3> points,
                                 std::span<const std::vector<Triangle>> surfaces, const ContourSet& contours);

// What in the contours forces a badly shaped cell, as text: its shortest edge joins two contour vertices, or
// it has a contour vertex at which the contour turns by an angle below 60 degrees. "" when neither.
class ForcedCells {
  public:
    // Requires: mesh and contours outlive this.
    ForcedCells(const TetMesh& mesh, const ContourSet& contours, std::span<const std::uint32_t> vertex_of);

    std::string reason(std::uint32_t cell) const;

    // Whether there is a reason.
    bool forced(std::uint32_t cell) const;

  private:
    // The contour points at the ends of the cell's shortest edge, or no_cell.
    struct ShortestEdge {
        std::uint32_t a = no_cell, b = no_cell;
        double length = 0;
    };
    ShortestEdge shortest_edge(std::uint32_t cell) const;
    // The first contour vertex of the cell with a small angle, or no_cell.
    std::uint32_t sharp_vertex(std::uint32_t cell) const;
    std::string slice_name(std::uint32_t point) const;
    double contour_angle(std::uint32_t point) const;

    const TetMesh& mesh_;
    const ContourSet& contours_;
    std::vector<std::uint32_t> point_at_;    // by mesh vertex: the first contour point there, or no_cell
    std::vector<std::uint32_t> contour_of_;  // by contour point
};

}  // namespace anatomesh
