// Tetrahedralization: the Delaunay tetrahedralization of a growing set of points.
//
// The only door to the Delaunay kernel: nothing outside tetrahedralize.cpp knows which one it is.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/mesh/tet_mesh.h"

namespace anatomesh {

// The cells at one moment, as flat arrays. neighbors[c][i] is the cell across the facet opposite vertex i,
// no_cell on the convex hull. previous[c] is the index the same cell had in the last snapshot taken, no_cell for
// a cell made since: what was computed for an unchanged cell carries over.
struct DelaunaySnapshot {
    std::vector<Cell> cells;
    std::vector<std::array<std::uint32_t, 4>> neighbors;
    std::vector<std::uint32_t> previous;
};

// Guarantees: exact predicates; cospherical points are decided the same way every time, so equal points in
// equal order give equal cells; all cells positive; the union of the cells is the convex hull of the points.
// Complexity: expected O(n log n) for points that fill space; points on few parallel planes alone may give many
// cells a point. Follows: Bowyer, Comput. J. 24, 1981; Watson, Comput. J. 24, 1981; insertion order along a
// Hilbert curve in random rounds (Amenta, Choi and Rote, SoCG 2003); CGAL 5.5 does the work.
class Tetrahedralization {
  public:
    // Errors: geometry E-DEL-001 fewer than four distinct points, or all of them in one plane (M-01).
    static Result<Tetrahedralization> create(std::span<const Vec3> points);

    Tetrahedralization(Tetrahedralization&&) noexcept;
    Tetrahedralization& operator=(Tetrahedralization&&) noexcept;
    ~Tetrahedralization();

    // Adds points; a point equal to one already there is dropped. Returns for each its vertex: an index into points().
    std::vector<std::uint32_t> insert(std::span<const Vec3> points);

    const std::vector<Vec3>& points() const;      // distinct, in order of first appearance
    std::span<const std::uint32_t> first_vertices() const;  // vertex of each point given to create()

    void snapshot(DelaunaySnapshot& snapshot);

  private:
    struct Kernel;
    explicit Tetrahedralization(std::unique_ptr<Kernel> kernel);
    std::unique_ptr<Kernel> kernel_;
};

}  // namespace anatomesh
