// surface_uncertainty: how sure every vertex of a model's surface is.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/uncertainty/left_out.h"

namespace anatomesh {

// Per vertex of the mesh, mm; 0 for vertices that no structure has on its surface.
struct SurfaceUncertainty {
    std::vector<float> evidence;  // distance from the nearest contour of its structure
    std::vector<float> left_out;  // error that leaving a slice out makes hereabouts
    std::vector<float> expected;  // what of it is to be expected here
};

// The errors of the left-out slices are averaged over the contour points near a vertex, weighted by the
// inverse of their squared distance; they were made at a distance `gap` from what was left. Expected is error
// x min(1, evidence / gap): nothing on a contour, the whole error as far from contours as the left-out slice
// was. Of several structures the surest counts. Requires: the model of the set (structures of the table are
// those of the set), and its left-out errors. Complexity: O(n log n).
SurfaceUncertainty surface_uncertainty(const ContourSet& set, const LeftOut& errors, const TetMesh& mesh,
                                       const RegionTable& regions, RunContext& context);

}  // namespace anatomesh
