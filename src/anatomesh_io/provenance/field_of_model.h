// The field that a model should be the mesh of: of its contours, by the options that its file names.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/pipeline/run/contour_field.h"
#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

struct FieldOfModel {
    ContourField made;                // .field empty: it cannot be made of these contours
    std::vector<double> volumes_mm3;  // per structure of the model; empty: not to be compared
    std::string caps;                 // as used
    std::string note;                 // by which options, or why there is none
};

// How the field was made, but for the ends, as far as the model's file says and a user may say.
FieldOptions field_rules_of(const MeshDescription& description);

// Where the file does not say how structures end (--caps), all ways are tried and the one is taken whose
// volumes are nearest to the model's; so with whether structures exclude each other, where the model was made
// with --priority or has hardly any overlaps. Volumes are compared where model and contours have the same
// structures. Errors: cancelled.
Result<FieldOfModel> field_of_model(const ModelFile& model, const ContourSet& contours, RunContext& context);

}  // namespace anatomesh
