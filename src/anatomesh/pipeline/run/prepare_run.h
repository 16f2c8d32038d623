// The steps "field" and "sample": what is known of the contours, and the points that the mesh begins with.
#pragma once

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/pipeline/run/run_state.h"

namespace anatomesh {

// What a model's options say of its field; the rest is by default.
FieldOptions field_options(const ModelOptions& options);

// Step "field": moves the contours to the origin, makes their field unless `known` has it, and decides the
// effort of the run. Requires: a kept contour set, and `known` has the facts of its slices. Errors: those of
// make_structure_field().
Result<PreparedRun> prepare_run(const ContourSet& source, const RunConfig& config, FieldAndVolumes known,
                                RunContext& context);

// Step "sample". Errors: those of sample_points().
Result<PointSample> sample_run(const PreparedRun& run, double size_mm, RunContext& context);

// Error limit E-PIP-001 if a mesh of the sample would have more cells than are allowed, or than there are
// numbers for; before the work.
Status check_cell_count(const PointSample& sample, std::uint64_t max_tetrahedra);

}  // namespace anatomesh
