// Volumes: of cells, and of drawn contours by plain slice integration.
#pragma once

#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// mm^3 per structure: the sum of the cells of its regions. Every structure of an overlap gets it whole.
std::vector<double> mesh_volumes(const TetMesh& mesh, const RegionTable& regions,
                                 std::size_t structure_count);

// Plain slice integration, mm^3 per structure: every drawn area times half the gap to the slice before plus
// half the gap to the slice after; the first and the last slice count their one gap on both sides (half a
// slice beyond the last contour). Slices that say nothing about a structure (slice_coverage.h: it is drawn on
// slices of its own) are none of its, if it has two or more. Where slices do not say all (says_all()), those of a
// structure on few of them are no thicker than few_slices.h says, and the last one of any other counts no more beyond than
// before it. Empty when the planes are not parallel (0.01 mm
// over the set) or there are fewer than two. Requires: a kept contour set (holes run against their outer
// contours); `coverage` of the set.
std::vector<double> slice_volumes(const ContourSet& set, const SliceCoverage& coverage);

}  // namespace anatomesh
