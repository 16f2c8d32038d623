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

// Voxels with low <= value <= high get label 1, which is structure number 1, called "threshold LOW" or "threshold
// LOW:HIGH". All others are outside, and so are those that are not a number. The result is the same for any number of
// threads. Errors: geometry E-THR-001 no voxel lies in the range (with the range of the image). Complexity: linear,
// parallel.
Result<LabelMap> threshold_image(const GreyImage& image, const ThresholdOptions& options,
                                 RunContext& context);

}  // namespace anatomesh
