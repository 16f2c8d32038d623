// Contours that followed the surface, as notes in the model's file.
#pragma once

#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

// Of each ("followed_contour", its number in the contours that the model was made of, how many segments of
// it were missed, how many points it had there and has now), then of these points and of those, in turn,
// ("followed_point", coordinates, so that they are read back as the same doubles): short lines, for readers
// that know no long ones. `kept`: what the model was made of.
void add_followed_notes(const Model& model, const ContourSet& kept, MeshDescription& description);

// The model's contours for a file: those that leave their planes by more than the tolerance are as in `kept`,
// since contours of files lie in planes.
ContourSet contours_in_planes(const Model& model, const ContourSet& kept, double tolerance_mm);

// Contours as they are drawn, and as they follow the surface.
struct BothContours {
    ContourSet drawn, on_surface;
    std::vector<FollowedContourReport> followed;
};

// Both, of either: of contours with each of those that the notes tell of as it is drawn, or as it follows the
// surface. Nothing if there are no notes, if they are not of such contours, or if what they tell of is not
// sound, and as near to what is drawn as a model may have it.
std::optional<BothContours> both_contours(const ContourSet& contours, const MeshDescription& description);

}  // namespace anatomesh
