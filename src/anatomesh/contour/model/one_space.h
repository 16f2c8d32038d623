// check_one_space: whether all contours have one frame of reference.
#pragma once

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/raw_contours.h"

namespace anatomesh {

// Each frame of reference has its own origin, so contours of two of them cannot be put together without a
// registration. With `take_for_one` they are taken as they are, with the warning W-RTS-007. Error: input E-RTS-010
// contours have two frames. Complexity: O(contours).
Status check_one_space(const RawContours& raw, bool take_for_one, RunContext& context);

}  // namespace anatomesh
