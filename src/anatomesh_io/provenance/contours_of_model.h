// The contours that a model is checked against: those given, brought to what the model was made of.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/share_walls.h"
#include "anatomesh/measure/report.h"
#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

struct ContoursOfModel {
    ContourSet drawn;
    std::optional<ContourSet> on_surface;     // where some are re-routed, as the model's file says
    std::vector<RoutedContourReport> routed;  // those
    ContourMovementReport movement{};         // by reconciling, where that was done to the contours given
};

// Of contours on more slices than the model was made of, as its file says (every, offset), those on its own
// are looked at. Where vertices of the contours are not the model's, walls are shared (share_walls.h), and
// where the model's file says that contours of slices that cross were made to agree (reconcile) or overlaps
// were given to one structure (priority), the same is done here, by the options that stand there, and kept if
// more vertices are the model's then, or as many where overlaps were given. With `share_first` walls are
// shared whatever comes of it. Contours of structures that the model lacks are left out, unless it has none
// of them. Errors: cancelled. Warnings: W-CMD-001 other axes than the model's, W-CMD-008 structures of
// another name or number than the model's, W-CMD-009 structures left out, W-CMD-010 structures that the
// contours lack, W-CMD-011 what was done to the contours. `file`: of the contours, for messages.
Result<ContoursOfModel> contours_of_model(ContourSet kept, const ModelFile& model, const WallOptions& walls,
                                          bool share_first, const std::string& file, RunContext& context);

// How far the contours' vertices are from the surfaces of their structures, in words, and what both span.
// Empty where none can be measured.
std::string distance_text(const ContourSet& contours, const ModelFile& model);

}  // namespace anatomesh
