// TetMesh: a tetrahedral mesh as flat arrays. Nothing stored that can be derived, no flags on elements.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

using Cell = std::array<std::uint32_t, 4>;
using Region = std::uint16_t;  // index into RegionTable; 0 is outside

// It stands for no cell, and for no vertex. [index; 2^32 - 1; D]
inline constexpr std::uint32_t no_cell = 0xFFFFFFFFu;

// Facet i of a cell is the one opposite vertex i; seen from outside a positive cell its vertices
// facet_vertices[i] run counter-clockwise. Facet id = 4 * cell + i.
inline constexpr std::array<std::array<int, 3>, 4> facet_vertices{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

// The six edges of a cell as pairs of its vertices.
inline constexpr std::array<std::array<int, 2>, 6> cell_edges{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

// Invariant: every cell is positively oriented (orient3d of its vertices > 0, that is
// dot(cross(p1 - p0, p2 - p0), p3 - p0) > 0); regions.size() == cells.size().
struct TetMesh {
    std::vector<Vec3> points;
    std::vector<Cell> cells;
    std::vector<Region> regions;  // per cell
};

// Which structures a region lies in: structures overlap, so a cell belongs to a set of them.
// members[r] is sorted; members[0] is empty (outside). Values are indices into ContourSet::structures.
struct RegionTable {
    std::vector<std::vector<std::uint32_t>> members{{}};

    bool contains(Region region, std::uint32_t structure) const {
        for (const std::uint32_t s : members[region]) {
            if (s == structure) return true;
        }
        return false;
    }
};

}  // namespace anatomesh
