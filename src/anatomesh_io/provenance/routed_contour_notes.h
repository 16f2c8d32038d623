// Re-routed contours, as notes in the model's file: written, and read back.
#pragma once

#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

// Adds a note of each: ("followed_contour", its number in the contours that the model was made of, how many
// segments of it were missed, how many points it had there and has now), then of these points and of those,
// in turn, ("followed_point", coordinates, so that they are read back as the same doubles). Lines are short,
// for readers that know no long ones.
void add_routed_contour_notes(const Model& model, MeshDescription& description);

// Contours as they are drawn, and as they are re-routed.
struct BothContours {
    ContourSet drawn, on_surface;
    std::vector<RoutedContourReport> routed;
};

// Both, of either: of contours with each of those that the notes tell of as it is drawn, or as it follows the
// surface. Nothing if there are no notes, if they are not of such contours, or if what they tell of is not
// sound, and as near to what is drawn as a model may have it.
std::optional<BothContours> both_contours(const ContourSet& contours, const MeshDescription& description);

}  // namespace anatomesh
