// MovableMesh: a mesh whose free vertices move, while its cells and regions stay.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

// References to what others own, for one call. The mesh holds the cells outside too, round every interface, so that
// no move can fold the outside; every vertex on its hull is fixed.
struct MovableMesh {
    TetMesh& mesh;                             // only its points change
    std::span<const std::uint32_t> neighbors;  // as cell_neighbors() gives them
    const VertexStars& stars;
    const std::vector<std::uint8_t>& fixed;  // by point; not 0: it does not move
    const RegionTable& regions;              // the structures of each
};

}  // namespace anatomesh
