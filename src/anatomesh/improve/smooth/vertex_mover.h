// VertexMover: moves one vertex of a mesh if the cells round it stay valid and no worse.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

// Connectivity and regions of the mesh must not change while a mover looks at it. Vertices that share no cell
// may be moved at the same time.
class VertexMover {
  public:
    // `stars`: the mesh's, which outlive the mover. `good_sine`: a least sine of dihedral angles that cells
    // inside may fall to; below it they may not get worse.
    VertexMover(TetMesh& mesh, const VertexStars& stars, double max_radius_edge, double good_sine = 0)
        : mesh_(mesh), stars_(stars), max_radius_edge_(max_radius_edge), good_sine_(good_sine) {}

    // Moves v to p and says true if every cell at v stays positive (exactly) and the worst radius-edge ratio
    // of the cells inside at v stays below the bound or falls, and no cell at v becomes nearly flat (six
    // volumes below a thousandth of the cube of its longest edge) unless one was flatter before, and the
    // least sine inside stays above `good_sine` or does not fall; else leaves it and says false.
    bool try_move(std::uint32_t v, Vec3 p);

    // The worst of the cells at a vertex.
    struct Shape {
        double squared_ratio;  // of those inside
        double flattest;       // of all
        double sine;           // of those inside
    };
    Shape shape(std::uint32_t v) const;

    // As try_move, but only if the worst ratio falls. `worst`: the vertex's shape, before and after.
    bool try_better(std::uint32_t v, Vec3 p, Shape& worst);

    // Calls move(v) for each of the vertices, which are distinct; at the same time for some that share no
    // cell. The order does not depend on `threads`. Complexity: linear in the cells at the vertices.
    void for_each_apart(std::span<const std::uint32_t> vertices, int threads,
                        const std::function<void(std::uint32_t)>& move) const;

    // As for_each_apart, but what comes of it is what the calls one after the other lead to, if move(v) moves
    // v at most and looks at nothing but the cells at v: of vertices that share a cell the first one moves
    // first. Requires: vertices that are distinct. Complexity: the same, and sorting n vertices; those that
    // hang together by shared cells are one thread's.
    void for_each_in_order(std::span<const std::uint32_t> vertices, int threads,
                           const std::function<void(std::uint32_t)>& move) const;

    double squared_ratio(std::uint32_t cell) const;  // circumradius / shortest edge
    double shortest_edge(std::uint32_t v) const;
    auto star(std::uint32_t v) const { return stars_.at(v); }  // the cells at v

  private:
    // Whether all are within the bounds by more than rounding: nearly always, and told sooner than their
    // shape.
    template <bool sines>
    bool clearly_good(std::uint32_t v) const;
    bool positive(std::uint32_t v) const;
    void move_group(std::span<const std::uint32_t> group, int threads,
                    const std::function<void(std::uint32_t)>& move) const;
    void fetch_cells(std::uint32_t v) const;
    void fetch_points(std::uint32_t v) const;

    TetMesh& mesh_;
    const VertexStars& stars_;
    double max_radius_edge_, good_sine_;
};

}  // namespace anatomesh
