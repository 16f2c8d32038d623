// chan_vese: a region that parts an image into two of even values, by a morphological active contour.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"

namespace anatomesh {

struct ChanVeseOptions {
    std::uint32_t smoothing = 1;      // passes of the curvature operator in each step. [0, 10]
    std::uint32_t iterations = 600;   // steps at most
    std::uint32_t surroundings = 10;  // voxels about the region whose mean is that of the outside. >= 1
};

struct ChanVeseResult {
    std::vector<std::uint8_t> inside;  // 0 or 1 a voxel
    double mean_inside = 0, mean_outside = 0;
    std::uint32_t iterations = 0;
    bool is_settled = false;
};

// Moves the boundary of `start` voxel by voxel to where a voxel's value is as far from the mean inside as
// from the mean of the surroundings, and smooths it. The outside is local: the box about the region, grown by
// the surroundings, so that what lies far away has no say; farther only while these are as the inside is. An
// image of one slice is treated in two dimensions. Lengths are voxels. Requires: one value and one start a
// voxel; a start that is not empty. Complexity: iterations times the voxels of that box. Deterministic.
// Follows: Chan and Vese, IEEE TIP 10, 2001; Marquez- Neila, Baumela and Alvarez, IEEE PAMI 36, 2014 (the
// morphological form).
Result<ChanVeseResult> chan_vese(const GreyImage& image, std::vector<std::uint8_t> start,
                                 const ChanVeseOptions& options, RunContext& context);

}  // namespace anatomesh
