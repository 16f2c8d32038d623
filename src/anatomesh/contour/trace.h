// trace_contours: sub-pixel contours of every structure of a label map, slice by slice.
#pragma once

#include <cstdint>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/contour_set.h"
#include "anatomesh/image/image.h"

namespace anatomesh {

struct TraceOptions {
    std::uint32_t every = 1;   // keep every Nth slice, >= 1
    std::uint32_t offset = 0;  // the first kept slice, 0 <= offset < every
    double min_area_mm2 = -1;  // pieces of a slice below it are left out and counted; negative: 4 pixels
    double epsilon_mm = -1;    // simplification bound; negative: 0.15 of the pixel; 0: every traced point
};

struct TraceStats {
    std::uint64_t points_traced = 0, points_kept = 0;
    std::uint32_t slices = 0, contours = 0;
    std::uint32_t islands_left_out = 0;
    double area_left_out_mm2 = 0;
    double epsilon_mm = 0;             // the bound used
    double max_distance_mm = 0;        // measured: of a traced vertex from the kept polygon
    std::uint32_t slice_axis = 2;      // along which voxel axis the slices are counted
};

struct TraceResult {
    ContourSet kept;
    TraceStats stats;
};

// Slices are taken along the voxel axis with the largest spacing (ties: the last axis). Contours run through the
// points where the edges between neighbouring pixel centres change label: at the threshold by linear
// interpolation where `grey` is given and the two grey values lie on its two sides, else half-way. Pixels that
// touch only at a corner are not joined. The image border counts as outside, half a pixel beyond the last pixel
// centre. Where two structures touch, their contours share every vertex; junctions of three are kept vertices.
// Guarantees: the invariants of a kept contour set, exclusive = true, drawn = false; kept vertices lie at least
// about a third of a pixel apart where epsilon allows.
// `grey` may be null; if given it has the label map's geometry; `threshold` is its iso-value.
// Complexity: linear in the voxels of the kept slices. Parallel over slices, same result at any thread count.
// Errors: geometry E-TRC-001 nothing to trace (with the labels that are empty).
Result<TraceResult> trace_contours(const LabelMap& labels, const GreyImage* grey, double threshold,
                                   const TraceOptions& options, RunContext& context);

}  // namespace anatomesh
