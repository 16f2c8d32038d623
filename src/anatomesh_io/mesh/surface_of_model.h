// surface_of: the surface of a model, as a file of surfaces holds it.
#pragma once

#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

// Every interface between two regions, with the model's description and its values at the surface's points.
// O(n log n)
SurfaceFile surface_of(const ModelFile& model);

}  // namespace anatomesh
