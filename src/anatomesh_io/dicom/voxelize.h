// voxelize: the regions of a tetrahedral model at the voxels of an image.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Per voxel the region of the cell that its centre lies in; 0 outside. A centre on a facet goes to the cell
// that comes first. Requires: a valid mesh; linearly independent steps. Complexity: the voxels in the boxes
// of the cells.
std::vector<std::uint16_t> voxelize(const TetMesh& mesh, const ImageGeometry& geometry, RunContext& context);

// A grid for a model without images: cubes of `size_mm` around all of it, along the axes.
ImageGeometry grid_around(const TetMesh& mesh, double size_mm);

}  // namespace anatomesh
