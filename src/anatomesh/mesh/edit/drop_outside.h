// drop_outside, compact_regions: a mesh of everything round a model becomes the mesh of the model alone.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Takes the cells of region 0 off, then the points that no cell uses; what stays keeps its order. `neighbors`
// holds four cells for each one, opposite its vertices, no_cell where there is none, and stays so. Returns
// the new number of every point, no_cell for those dropped. Linear.
std::vector<std::uint32_t> drop_outside(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                        unsigned threads);

// Keeps the regions that a cell lies in, those of fewer structures first, then ordered by their structures:
// so their numbers do not depend on the order in which a method met them.
void compact_regions(TetMesh& mesh, RegionTable& table);

}  // namespace anatomesh
