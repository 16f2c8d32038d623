// segment_slices: a structure slice by slice, the contour of one slice handed on to the next; and the filter
// of speckle that goes before it.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh_io/segment/segment.h"

namespace anatomesh {

// Each slice (i, j) by itself, in two dimensions: slices of a volume, or frames that lie anywhere in space.
// Methods without a seed treat every slice alike. The others begin in the slices of their seeds; what is
// found there is where the next slice begins, on both sides, until nothing is left, or until the region grows
// into another one (less than `kept_share` of it lies in the one before: a leak, mostly), which ends the way
// there. `order` names the slices as they follow each other in space; empty: 0, 1, 2 ... A slice between two
// seeded ones belongs to the nearer of them. Requires: those of segment_image(). Errors and warnings: those
// of segment_image(); W-SGM-003 where the region became another one and was not followed. Result.low and
// high: of the first seeded slice.
struct SliceOptions {
    double kept_share = 0.4;  // of a region that the one before must hold, else it is not followed. [0, 1]
    std::vector<std::uint32_t> order;
};
Result<Segmentation> segment_slices(const GreyImage& image, const SegmentOptions& options,
                                    const SliceOptions& slices, RunContext& context);

// Median of every pixel's surroundings in its slice, `radius_mm` about it: takes the speckle of ultrasound
// and keeps edges. Errors: internal E-SGM-003.
Status reduce_speckle(GreyImage& image, double radius_mm, RunContext& context);

}  // namespace anatomesh
