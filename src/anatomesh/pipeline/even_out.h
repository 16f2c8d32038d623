// even_out: a small model whose cells came out long in the mean is built again with more of them.
//
// Where most vertices are fixed - a few thick slices - nothing that follows refinement makes much of the
// cells, so refinement itself must bring their mean ratio lower; how far shows in what comes of it.
#pragma once

#include <functional>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/pipeline/build_model.h"

namespace anatomesh {

// `model`, if its mean ratio is at most 0.95 or it has 30,000 cells and more. Else, of it and those that
// `build` makes with lower and lower RefinementOptions::even_mean, the first one with such a mean, or that
// with the least: of those for which nothing else is worse (is_no_worse(); `size_mm`, the edge length, tells
// what is near enough to the field). The context has the warnings of the model that is returned. At most two
// more builds. Requires: the warnings of the model in the context; `build` leaves those of its own there.
// Errors: of a build that was cancelled.
Result<Model> even_out(Model model, double size_mm, const std::function<Result<Model>(double)>& build,
                       RunContext& context);

}  // namespace anatomesh
