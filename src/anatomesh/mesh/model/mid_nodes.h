// MidNodes: what makes quadratic tetrahedra (ten nodes) of the cells of a TetMesh: a node on every edge.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Node i of a cell's six lies on the edge cell_edges[i]. Cells that share an edge share its node.
// Invariant: one entry in `cells` per cell of the mesh, or none at all (the cells are linear).
struct MidNodes {
    std::vector<Vec3> points;
    std::vector<std::array<std::uint32_t, 6>> cells;  // indices into points

    bool empty() const { return cells.empty(); }
    friend bool operator==(const MidNodes&, const MidNodes&) = default;
};

}  // namespace anatomesh
