// RunConfig: what differs between the runs that build_model() makes of the same contours.
#pragma once

#include <cstddef>

#include "anatomesh/pipeline/model/model.h"
#include "anatomesh/refine/refinement_rounds.h"

namespace anatomesh {

struct RunConfig {
    ModelOptions options;
    bool size_given = false;            // by the user; else it is the default, or one tried after it
    bool may_conform = true;            // contour segments may be split for each other's sake
    std::size_t runs_before = 0;        // that did not conform, made for other reasons than the mean ratio
    std::size_t ill_shaped_before = 0;  // of these, refused or of ill-shaped cells
    double target_mean_ratio = RefinementOptions{}.target_mean_ratio;  // as there
};

}  // namespace anatomesh
