// ContourLimits: how much a contour file may hold. Checked before memory is taken.
#pragma once

#include <cstdint>

#include "anatomesh/geom/numbers.h"

namespace anatomesh {

struct ContourLimits {
    std::uint64_t structures = 10'000;             // ROIs, labels. [1, 2^31)
    std::uint64_t contours = 1'000'000;            // of all structures; also bounds the slices. [1, 2^32)
    std::uint64_t points_per_contour = 4'000'000;  // [1, 2^32)
    std::uint64_t points = 50'000'000;             // of all contours. [1, 2^32)
    double coordinate_mm = coordinate_bound_mm;    // largest |x|, |y|, |z|. > 0, finite
};

}  // namespace anatomesh
