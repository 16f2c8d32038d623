// retry_for_mean_ratio: a small model whose cells came out long in the mean is built again with more of them.
//
// Where most vertices are fixed - a few thick slices - nothing that follows refinement makes much of the
// cells, so refinement itself must bring their mean ratio lower; how far shows in what comes of it.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/pipeline/model/model.h"

namespace anatomesh {

struct RetriedModel {
    Model model;
    std::optional<double> target_mean_ratio;  // that it was built with; none: it is the first one
    std::size_t runs = 0;                     // models built besides
};

// Returns `model` if its mean ratio is at most 0.95 or it has 30,000 cells or more. Else builds up to three with
// falling RefinementOptions::target_mean_ratio. A build counts only if it is no worse than `model` (is_no_worse()).
// Of these the first that reaches the mean is taken. It gives way only to one with fewer cells that are bad without a
// reason. If none reaches it, the last that lowers the mean by 0.005 is taken. `size_mm` is the edge length: a surface
// within half of it is near enough to the field. One cell in 2,000 may be bad without a reason. The context has the
// warnings of the model that is returned. Requires: the warnings of `model` are in the context; `build` leaves those of
// its own there. Errors: of a build that was cancelled.
Result<RetriedModel> retry_for_mean_ratio(Model model, double size_mm,
                                          const std::function<Result<Model>(double)>& build,
                                          RunContext& context);

}  // namespace anatomesh
