// ill_shaped_cells: the cells that a model may have only where its contours force them.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Those of a structure that are beyond what clause 4 allows of a cell that nothing forces
// (contract::bad_radius_edge, contract::bad_dihedral_degrees; measure/certificate/certificate.h), rising. The same at any
// thread count. Complexity: O(cells).
std::vector<std::uint32_t> ill_shaped_cells(const TetMesh& mesh, std::size_t threads);

}  // namespace anatomesh
