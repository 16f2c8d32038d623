// make_model: one call from contours to a checked model, as the program makes it.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh/pipeline/prepare_contours.h"

namespace anatomesh {

struct MakeModelOptions {
    // What is done to the contours, and the rules of the field that the model is the mesh of (`field`).
    PrepareOptions prepare;
    // Target edge length. mm, [0.01, 1000]; 0: found from the contours.
    double size_mm = ModelOptions{}.size_mm;
    // As in ModelOptions.
    double max_radius_edge = ModelOptions{}.max_radius_edge;
    std::uint64_t max_tetrahedra = ModelOptions{}.max_tetrahedra;
    std::uint64_t spare_dense_above = ModelOptions{}.spare_dense_above;
    // A model with a given edge length that would need more, as estimated, is refused. bytes; 0: none is.
    std::uint64_t max_memory_bytes = 0;
    // What else the caller does to the model, for its report. They stand in the report after the options of
    // reconciling.
    std::vector<std::pair<std::string, std::string>> report_options;
};

// The options of build_model() by these. Contours of crossing slices may leave their places by
// `prepare.reconcile.max_disagreement_mm` to follow the surface, unless contours are to stay as drawn.
ModelOptions model_options(const MakeModelOptions& options);

// prepare_contours(), build_model(), and a report that tells of both: everything but input files and command.
// Guarantees: those of both; the same at any thread count. Errors: those of both; limit E-CMD-014, a model
// larger than is allowed, or than anybody asked for (estimate.h). Complexity: that of build_model().
Result<Model> make_model(const RawContours& raw, const MakeModelOptions& options, RunContext& context,
                         const StageObserver& observer = {});

// The same of contours that are a kept set already: traced, or cleaned by the caller.
Result<Model> make_model(ContourSet kept, const MakeModelOptions& options, RunContext& context,
                         const StageObserver& observer = {});

// The second half alone. Requires: contours that were prepared by these options.
Result<Model> make_model(const PreparedContours& prepared, const MakeModelOptions& options,
                         RunContext& context, const StageObserver& observer = {});

}  // namespace anatomesh
