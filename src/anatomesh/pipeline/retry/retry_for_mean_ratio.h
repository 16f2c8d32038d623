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

// `model`, if its mean ratio is at most 0.95 or it has 30,000 cells and more. Else, of it and those that
// `build` makes with lower and lower RefinementOptions::target_mean_ratio, the first one with such a mean and
// no more bad cells without a reason, or the one with fewest of them, or, where none has it, the last whose
// mean is lower by 0.005: of those that are no worse than `model` (is_no_worse(); `size_mm`, the edge length:
// within half of it a surface is near enough to the field; one cell in 2000 may be bad without a reason). The
// context has the warnings of the model that is returned. At most three more builds. Requires: the warnings
// of the model in the context; `build` leaves those of its own there. Errors: of a build that was cancelled.
Result<RetriedModel> retry_for_mean_ratio(Model model, double size_mm,
                                          const std::function<Result<Model>(double)>& build,
                                          RunContext& context);

}  // namespace anatomesh
