// threshold_image: the voxels of a grey image between two values, as a label map of one structure.
#pragma once

#include <limits>

#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"

namespace anatomesh {

struct ThresholdOptions {
    double low = 0;                                         // in the image's own unit (CT: HU). Finite
    double high = std::numeric_limits<double>::infinity();  // >= low; infinity: no upper bound
};

// Voxels with low <= value <= high get label 1: structure number 1, called "threshold LOW" or "threshold
// LOW:HIGH". All others, and those that are not a number, are outside. Complexity: linear. Parallel, same
// result at any thread count. Errors: geometry E-THR-001 no voxel lies in the range (with the range of the
// image).
Result<LabelMap> threshold_image(const GreyImage& image, const ThresholdOptions& options,
                                 RunContext& context);

}  // namespace anatomesh
