// trace_contours: sub-pixel contours of every structure of a label map, slice by slice.
#pragma once

#include <cstdint>
#include <optional>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/image/image.h"

namespace anatomesh {

// What lies between the slices of a structure that is painted on some slices alone (sparse_structures.h).
enum class BetweenSparse : std::uint8_t {
    nothing,      // each painted slice is a plate: the label map says all
    interpolated  // what the contours of the slices tell, as if they were drawn by hand
};

struct TraceOptions {
    // The axis of the patient that slices follow, x, y or z: the voxel axis nearest to it. [0, 2]; nothing: the
    // voxel axis with the largest spacing.
    std::optional<std::uint32_t> axis;
    BetweenSparse between_sparse = BetweenSparse::nothing;
    std::uint32_t every = 1;   // keep every Nth slice, >= 1
    std::uint32_t offset = 0;  // the first kept slice, 0 <= offset < every
    double min_area_mm2 = -1;  // pieces of a slice below it are left out and counted; negative: 4 pixels
    double epsilon_mm = -1;    // simplification bound; negative: 0.15 of the pixel; 0: every traced point
};

struct TraceStats {
    std::uint64_t points_traced = 0, points_kept = 0;  // a point that two contours share counts once
    std::uint32_t slices = 0, contours = 0;
    std::uint32_t islands_left_out = 0;  // pieces of a structure, given to what surrounds them
    double area_left_out_mm2 = 0;
    std::uint32_t holes_filled = 0;  // pieces of the outside, given to what surrounds them
    double area_filled_mm2 = 0;
    double epsilon_mm = 0;         // the bound used
    double max_distance_mm = 0;    // measured: of a traced vertex from the kept polygon, before vertices move
    double max_shift_mm = 0;       // measured: of a kept vertex, to give outlines the areas of their pixels
    std::uint32_t slice_axis = 2;  // along which voxel axis the slices are counted
};

struct TraceResult {
    ContourSet kept;
    TraceStats stats;
};

// Slices are taken along the axis of the options, else along the voxel axis with the largest spacing; of equal
// ones, the last. Slices before the first and
// after the last one with a contour are left out; those between are kept though they may be empty.
//
// Contours run through the points where the edges between neighbouring pixel centres change label. This is at the
// threshold, by linear interpolation, where `grey` is given and the two grey values lie on its two sides; else half-way. They keep 1/64 pixel away from pixel centres, 0.15 where two pieces of boundary pass the same
// centre. The image border counts as outside, half a pixel beyond the last pixel centre.
//
// Pixels of a structure that touch only at a corner are not joined in the outside. Where two structures alternate
// around a corner, the one with the lower number is joined. Where only the pixels of one diagonal are equal, these are
// joined. Where two structures touch, their contours share every vertex; where three or more meet, they share a
// junction, which is kept.
//
// Before a slice is traced, pieces below the minimum area (islands of a structure and holes alike) are given
// to the label that surrounds them most, and counted.
//
// Without `grey` the kept vertices then move by the least that gives every contour the area of its pixels, half a pixel of
// which cut corners have lost (restore_areas.h). A pixel centre stays in its structure while epsilon is below 0.35 pixel.
//
// `grey` may be null; else it has the label map's geometry, and `threshold` is its iso-value.
//
// Guarantees: the invariants of a kept contour set, exclusive = true, complete = true, drawn = false; exclusive
// and complete are false where what lies between sparse slices is to be interpolated. Kept vertices lie about a third
// of a pixel apart or more where epsilon allows, and a tenth of a pixel from other segments where the traced points
// do. No simplification makes contours cross, touch or change sides (contour/simplify/chains.h). The result is the
// same for any number of threads. Complexity: linear in the voxels of the kept slices; parallel over slices.
// Errors: geometry E-TRC-001 nothing to trace (with the labels that are empty), E-TRC-002 no slice kept; limit
// E-TRC-003 slice too large. Warnings: W-TRC-001 cut by the image border, W-TRC-002 islands left out, W-TRC-003 holes
// filled, W-TRC-004 structure without a contour, W-TRC-005 islands left out are over 5 % of the area, W-TRC-006 pieces
// that no kept slice meets, W-TRC-007 a structure that is painted on some slices alone, W-TRC-008 none is, W-TRC-009 outlines whose volume is not that of the voxels, W-CON-024 simplification changed the area of a structure by more than 5 %.
// Source: Lorensen and Cline, SIGGRAPH 1987, in the plane; many labels as in Hege et al., ZIB SC-97-05, 1997.
Result<TraceResult> trace_contours(const LabelMap& labels, const GreyImage* grey, double threshold,
                                   const TraceOptions& options, RunContext& context);

}  // namespace anatomesh
