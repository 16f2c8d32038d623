// Contours that followed the surface, as notes in the model's file.
#pragma once

#include <optional>

#include "anatomesh/contour/contour_set.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

// Of each ("followed_contour", its number in the contours that the model was made of, and the coordinates of
// all of its points as it is now, each so that it is read back as the same double).
void add_followed_notes(const Model& model, MeshDescription& description);

// The contours that a model was made of, with those in the place of theirs that the notes tell of. Nothing if
// there are none, or if they are not of such contours.
std::optional<ContourSet> with_followed(const ContourSet& contours, const MeshDescription& description);

}  // namespace anatomesh
