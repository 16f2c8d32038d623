// StageObserver: a caller's look at the mesh while it is made.
#pragma once

#include <functional>
#include <string>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Called with the mesh after each stage that has one ("cull", "refine", "cut", "improve", "certificate", in
// this order; again from the start on a further attempt): for looking and dumping. The last round is that of
// the model that is returned; where another one was tried after it, it is built once more for that.
using StageObserver = std::function<void(const std::string& stage, const TetMesh& mesh)>;

}  // namespace anatomesh
