// check_one_space: contours of several frames of reference do not lie beside each other as drawn.
#pragma once

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/raw_contours.h"

namespace anatomesh {

// Each frame of reference has its own origin, so that contours of two of them cannot be put together without
// a registration. Error: input E-RTS-010 contours of two frames. With `take_for_one` they are taken as they
// are, with the warning W-RTS-007. Complexity: O(contours).
Status check_one_space(const RawContours& raw, bool take_for_one, RunContext& context);

}  // namespace anatomesh
