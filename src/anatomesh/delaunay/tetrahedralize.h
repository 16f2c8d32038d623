// Tetrahedralization: the Delaunay tetrahedralization of a growing set of points.
//
// The only door to the Delaunay kernel: nothing outside this room includes it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// The cells at one moment, as flat arrays. neighbors[c][i] is the cell across the facet opposite vertex i,
// no_cell on the convex hull. A cell keeps its place as long as it is there: what was computed for an
// unchanged cell stays true. New cells take the places of those that went, in an order in which neighbours
// are near in space; where more went than came, the last cells move into the places left. Cells, neighbors
// and their order are a function of the points and their batches, not of the threads.
struct DelaunaySnapshot {
    std::vector<Cell> cells;
    std::vector<std::array<std::uint32_t, 4>> neighbors;
    std::vector<std::uint32_t> changed;  // the places that have another cell than before; rising
};

// Guarantees: exact predicates for all finite doubles, however large or small. Cospherical points are decided
// as if moved by infinitely small amounts that depend on their coordinates alone (in_perturbed_sphere): one
// set of points has one set of cells, whatever the order of insertion, the batches and the number of threads.
// All cells positive, none flat; the union of the cells is the convex hull of the points. Complexity:
// expected O(n log n) for points that fill space; points on few parallel planes alone may give many cells a
// point. 64 bytes a cell. Follows: see kernel.h.
class Tetrahedralization {
  public:
    // More points are refused: links of cells are numbers of 32 bits. [points; > 0; D links of 32 bits]
    static constexpr std::size_t most_points = std::size_t{1} << 27;

    // `threads`: at least 1; how many work at once.
    // Errors: geometry E-DEL-001 fewer than four distinct points, or all of them in one plane (M-01);
    // geometry E-DEL-002 a coordinate is not finite; limit E-DEL-003 more than most_points points.
    static Result<Tetrahedralization> create(std::span<const Vec3> points, int threads = 1);

    Tetrahedralization(Tetrahedralization&&) noexcept;
    Tetrahedralization& operator=(Tetrahedralization&&) noexcept;
    ~Tetrahedralization();

    // Adds points; a point equal to one already there is dropped. Returns for each its vertex: an index into
    // points(). Requires: finite coordinates.
    std::vector<std::uint32_t> insert(std::span<const Vec3> points, int threads = 1);

    const std::vector<Vec3>& points() const;                // distinct, in order of first appearance
    std::span<const std::uint32_t> first_vertices() const;  // vertex of each point given to create()

    // The cells as they are now; valid until the next call. Complexity: linear in the changes since the last
    // one.
    const DelaunaySnapshot& snapshot(int threads = 1);
    const DelaunaySnapshot& last_snapshot() const;  // as the last call left it; empty before the first

    std::uint64_t cells_made() const;  // by all insertions, cells that went again included

  private:
    struct State;
    explicit Tetrahedralization(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace anatomesh
