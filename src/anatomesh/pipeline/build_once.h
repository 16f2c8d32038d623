// build_once: one run of the method, from kept contours to a checked model, one line a stage.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh/pipeline/retry/retry_policy.h"
#include "anatomesh/refine/refinement_rounds.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// Which of the runs that build_model() makes it is.
struct RunConfig {
    ModelOptions options;
    bool size_given = false;  // by the user; else it is the default, or one tried after it
    bool may_conform = true;  // contour segments may be split for each other's sake
    std::size_t before = 0;   // so many runs without that, made for other reasons than the mean ratio
    std::size_t ill_shaped_before = 0;  // of these, refused or of ill-shaped cells
    double target_mean_ratio = RefinementOptions{}.target_mean_ratio;  // as there
};

// What does not depend on the size.
struct FieldAndVolumes {
    std::shared_ptr<const SliceFacts> slices;  // of the contours as the stages see them, relative_to()
    std::shared_ptr<const StructureField> field;
    std::vector<StructureVolume> volumes;  // of the field, by structure
    std::size_t warnings = 0;              // of the context, when the field was made
};

struct BuiltOnce {
    Result<Model> model;
    RunScore score;
    FieldAndVolumes known;
    double size_mm = 0;  // the edge length aimed at; 0: it did not come so far
    WorkReport work;
};

// `known`: of a run before, or the slices alone. Requires and errors: as build_model(). The same result every time.
BuiltOnce build_once(const ContourSet& contours, const RunConfig& config, RunContext& context,
                     const StageObserver& observer, FieldAndVolumes known);

}  // namespace anatomesh
