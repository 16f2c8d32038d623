// segment_image: one structure of a grey image, by intensity, by growing from seeds, or by an active contour.
//
// Lengths are millimetres, measured along the voxel axes; a sheared image (gantry tilt) is treated as if its
// axes were at right angles. The filters are ITK's.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"

namespace anatomesh {

enum class SegmentMethod : std::uint8_t {
    threshold,   // all voxels of the range
    otsu,        // all voxels above Otsu's threshold
    grow,        // the voxels of the range that faces join to a seed
    confidence,  // as grow; the range is mean +- spread deviations around the seeds, then
                 // of the region
    region,  // active contour from the seeds' balls, driven by mean +- spread deviations of the values there
    geodesic,  // active contour from the seeds' balls, halted by edges
    chan_vese  // active contour from the seeds' balls, between the mean inside and that of the surroundings
};

struct SegmentOptions {
    SegmentMethod method = SegmentMethod::threshold;
    double low = 0, high = std::numeric_limits<double>::infinity();  // threshold, grow: in the image's unit
    std::vector<std::array<std::uint32_t, 3>> seeds;                 // voxels; all methods but two need one,
    std::vector<std::uint8_t> start;              // or a region, a byte a voxel, to begin with
    std::optional<double> known_low, known_high;  // the range, where it is known: confidence, region
    double seed_radius_mm = 6;       // of the balls around the seeds, at least 1.5 voxels. (0, 1000]
    double spread = 2.5;             // standard deviations: confidence, region. (0, 100]
    double curvature = 1;            // smoothness of active contours: weight of their curvature. [0, 100]
    std::uint32_t iterations = 600;  // of active contours, at most. [1, 100000]
};

struct CleanMaskOptions {
    double median_mm = 0, open_mm = 0, close_mm = 0;  // radii; 0: not done. [0, 100]
    bool fill_holes = false;                          // what the structure encloses in space
};

struct Segmentation {
    LabelMap labels;  // one structure, number 1, no name
    // The range that was used: threshold, otsu, grow, confidence, region.
    std::optional<double> low, high;
    std::uint32_t iterations = 0;  // of an active contour
};

// Requires: seeds lie in the image; a start has a byte a voxel; low <= high; options in their ranges.
// Complexity: linear in the voxels; active contours: iterations times their surface, in voxels. Same result
// at any thread count. Errors: geometry E-SGM-001 no voxel is left (with what the seeds' values are, or the
// image's range), E-SGM-002 the seed's value lies outside the range; internal E-SGM-003 a filter failed.
// Warnings: W-SGM-001 the result takes more than half of the image, W-SGM-002 the active contour was still
// moving at the end. Follows: Otsu 1979; Caselles, Kimmel and Sapiro 1997 (geodesic); Lefohn and Whitaker
// (region).
Result<Segmentation> segment_image(const GreyImage& image, const SegmentOptions& options,
                                   RunContext& context);

// Median, opening, closing, filling of holes, in this order. Requires: one structure.
// Errors: geometry E-SGM-004 nothing is left; internal E-SGM-003.
Status clean_mask(LabelMap& labels, const CleanMaskOptions& options, RunContext& context);

}  // namespace anatomesh
