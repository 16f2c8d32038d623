// ratio_slopes: where moving a vertex makes the cells round it better, found in one sweep over the cells.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct RatioSlopes {
    // By vertex: how steeply the sum of the radius-edge ratios of the cells inside round it falls when it
    // moves, on an interface along that: over the sum, for a way of the length of an edge (root mean square).
    // 0 where no cell is inside, and for fixed vertices.
    std::vector<float> steepness;
    std::vector<std::uint8_t> on_interface;  // whether cells of several regions meet there
    std::uint64_t cells = 0;                 // inside
    double mean = 0;                         // of their ratios
};

// The gradient of a circumradius R with centre o for the vertex x of barycentric coordinate l in o is
// l (x - o) / R. Guarantees: the same for any number of threads. Requires: `neighbors` as cell_neighbors()
// gives them; all cells positive. Complexity: linear; 44 bytes for every vertex, twice.
RatioSlopes ratio_slopes(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                         std::span<const std::uint8_t> fixed, int threads);

}  // namespace anatomesh
