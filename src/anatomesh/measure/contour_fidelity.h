// Whether the contours are in the model: their vertices, bit for bit, and their segments as chains of edges.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/contradicted_segments.h"
#include "anatomesh/mesh/model/surface_mesh.h"
#include "anatomesh/mesh/model/tet_mesh.h"

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
    std::vector<std::uint32_t> segments_missed;  // by contour
    std::vector<SegmentOfContour> missed;        // by structure, contour and index
};

// `surfaces[s]` is the surface of the contour set's structure s as triangles of `points`.
// A vertex is on the surface when a surface vertex has its three coordinates as doubles. A segment is when a
// chain of surface edges leads along it, none of whose vertices is further from it than 1e-6 of its length
// and 1e-12 of the coordinates' size. Complexity: O(n log n).
ContourFidelity contour_fidelity(std::span<const Vec3> points,
                                 std::span<const std::vector<Triangle>> surfaces, const ContourSet& contours);

// What in the contours forces a badly shaped cell, as text: its shortest edge joins two contour vertices, it
// has a contour vertex at which the contour turns by an angle below 60 degrees or meets another one at less
// than 30, or a vertex on a contour that lies far nearer to another vertex or segment of a contour than edges
// are long. "" when none of these.
class ForcedCells {
  public:
    // Requires: mesh and contours outlive this.
    ForcedCells(const TetMesh& mesh, const ContourSet& contours, std::span<const std::uint32_t> vertex_of);

    std::string reason(std::uint32_t cell) const;

    // Whether one of the first two reasons holds.
    bool forced(std::uint32_t cell) const;

    // Whether it forces every cell that it is a vertex of, by what find_constraint_limited() found or a small
    // angle.
    bool limits(std::uint32_t vertex) const;

    // Looks for the other reasons at the vertices of these cells: another contour vertex or segment nearer
    // than `distance_mm`, or another contour at a small angle. Complexity: O(segments + cells).
    void find_constraint_limited(std::span<const std::uint32_t> cells, double distance_mm);
    // At these vertices, rising, instead.
    void find_constraint_limited_at(const std::vector<std::uint32_t>& vertices, double distance_mm);

  private:
    // The contour points at the ends of the cell's shortest edge, or no_cell.
    struct ShortestEdge {
        std::uint32_t a = no_cell, b = no_cell;
        double length = 0;
    };
    ShortestEdge shortest_edge(std::uint32_t cell) const;
    // The first contour vertex of the cell with a small angle, or no_cell.
    std::uint32_t sharp_vertex(std::uint32_t cell) const;
    // A segment, and how far from a vertex it passes.
    struct NearSegment {
        std::uint32_t from;
        Vec3 a, b;
        double distance;
    };
    // What limits a vertex: the starts of the contour segment that it is on and of the one that comes
    // nearest, and its distance; or their angle.
    struct ConstraintLimit {
        std::uint32_t own = no_cell, segment = no_cell;
        double distance = 0, angle_deg = 180;
    };
    std::string limit_reason(std::uint32_t cell) const;
    Vec3 segment_end(std::uint32_t from) const;
    ConstraintLimit limit_of_vertex(std::uint32_t point, const std::vector<NearSegment>& near,
                                    double distance_mm) const;
    ConstraintLimit limit_of_segment(const std::vector<NearSegment>& near) const;
    static double angle_between(const NearSegment& s, const NearSegment& t, Vec3 p);
    std::string slice_name(std::uint32_t point) const;
    double contour_angle(std::uint32_t point) const;

    const TetMesh& mesh_;
    const ContourSet& contours_;
    std::vector<std::uint32_t> point_at_;    // by mesh vertex: the first contour point there, or no_cell
    std::vector<std::uint32_t> contour_of_;  // by contour point
    std::map<std::uint32_t, ConstraintLimit> constraint_limited_;  // by mesh vertex
};

// By vertex: whether it is one of `vertices` (rising) and ForcedCells::limits() it, where contours are near
// to each other below `share` of the mean edge of the cells inside. Complexity: O(segments + cells).
std::vector<std::uint8_t> constraint_limited_vertices(const TetMesh& mesh, const ContourSet& contours,
                                                      std::span<const std::uint32_t> vertex_of,
                                                      const std::vector<std::uint32_t>& vertices,
                                                      double share);

}  // namespace anatomesh
