// NodeLattice: values of a field at the nodes of a lattice, asked for where a surface passes alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// By its lowest corner, in steps. Corner c of a cell is (c & 1, c >> 1 & 1, c >> 2) steps from that.
using Cell = std::array<std::int32_t, 3>;

// The cell that holds a point.
Cell cell_at(Vec3 p, double step);

// Sets of corners, a bit each: on the lower and the upper side along x, y and z.
inline constexpr std::array<unsigned, 6> face_corners{0x55, 0xAA, 0x33, 0xCC, 0x0F, 0xF0};

class NodeLattice {
  public:
    // Over all cells that meet the box, and one more on each side. Requires: step > 0, a box that is not empty. Error: limit
    // E-LIV-201 more cells than `max_cells`.
    static Result<NodeLattice> over(const Box3& box, double step, std::uint64_t max_cells);

    // Error: limit E-LIV-201 a lattice over the box would have more cells, or cells more than 1e9 steps from the origin.
    static Status check_size(const Box3& box, double step, std::uint64_t max_cells);

    // Returns whether the cell lies in the lattice and is visited for the first time.
    bool visit(Cell cell);

    // Asks for the values at all corners of the cells. Requires: they were visited. Same result at any number of
    // threads.
    void ask(std::span<const Cell> cells, const StructureField& field, std::uint32_t structure, int threads);

    // The corners at which the value is negative. Requires: they were asked for.
    unsigned inside_corners(Cell cell) const;

    // The mean of where the surface crosses the edges of a cell, straight between the values at their ends, and the
    // direction in which the values rise there. Asks for what was not asked for. Requires: the surface crosses the cell.
    struct Vertex {
        Vec3 at, normal;
    };
    Vertex vertex(Cell cell, const StructureField& field, std::uint32_t structure);

    std::uint64_t values() const { return asked_count_; }

  private:
    std::size_t cell_index(Cell cell) const;
    std::size_t node_index(Cell cell, unsigned corner) const;
    Vec3 node_at(std::size_t node) const;

    double step_ = 1;
    Cell low_{};                         // the lowest cell
    std::array<std::size_t, 3> size_{};  // in cells
    std::vector<std::uint8_t> visited_;  // by cell
    std::vector<std::uint8_t> asked_;    // by node
    std::vector<double> values_;         // by node
    std::uint64_t asked_count_ = 0;
};

}  // namespace anatomesh
