// The structure field of slices along paths. Reached through make_structure_field().
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// Each path has the field of parallel slices (parallel_field.h) in its chart coordinates, and says nothing of what it
// does not draw. A point takes of each structure the least value of all paths that draw it, and of all gaps of a path
// that it lies in: tubes that meet are united. Slices on no path cross others of their tube (paths_of_slices.h): they
// shape nothing but say that the tube goes on there, and W-FLD-019 names them. Requires: slices of `set`, along paths.
// Errors: those of parallel_field.h. Complexity of a query: O(log slices + gaps near the point) queries of fields of
// parallel slices.
Result<std::shared_ptr<const StructureField>> make_path_field(const ContourSet& set, const SliceFacts& slices,
                                                              const FieldOptions& options,
                                                              RunContext& context);

// Returns by contour whether it lies on no path, so that the surface does not follow it. Requires: as above.
// Complexity: O(contours).
std::vector<std::uint8_t> contours_off_paths(const ContourSet& set, const SliceFacts& slices);

// Returns by contour whether a part of it lies inside what other paths have of its structure: there a branch begins in
// its parent, the tubes are united, and the surface cannot follow the contour. Requires and errors: as above.
// Complexity: a query of the field for each quarter of a spacing along the contours.
Result<std::vector<std::uint8_t>> contours_inside_other_paths(const ContourSet& set, const SliceFacts& slices,
                                                              const FieldOptions& options,
                                                              RunContext& context);

}  // namespace anatomesh
