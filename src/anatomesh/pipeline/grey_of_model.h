// grey_of_model: the mean grey value of every tetrahedron of a model, with what the report says of it.
#pragma once

#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct GreyOfModel {
    std::vector<double> values;  // per cell
    StageReport stage;           // "grey"; without `points`, since mid-nodes are the caller's
};

// grey_values() with its defaults. `file`: what messages call the image. Warning: W-ELM-001 tetrahedra outside
// the image. Requires and errors: as grey_values().
Result<GreyOfModel> grey_of_model(const TetMesh& mesh, const GreyImage& image, const std::string& file,
                                  RunContext& context);

}  // namespace anatomesh
