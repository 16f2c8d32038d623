// slice_stack: parallel contour slices as the slices of an image.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/slice/scanline.h"
#include "anatomesh/image/image.h"

namespace anatomesh {

struct SliceStackOptions {
    double pixel_mm = 0;  // of the image. > 0; 0: that of the source, or one found
    double slice_mm = 0;  // thickness of one slice alone. > 0; 0: as the source states it, or a pixel
    std::uint32_t margin_pixels = 4;  // around the box of all contours. [0, 1000]
    std::uint64_t max_voxels = std::uint64_t{1} << 34;
};

struct SliceStack {
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    ImageGeometry geometry;
    Plane frame;                       // whose coordinates `grid` has
    PixelGrid grid;                    // of every slice
    std::vector<std::uint32_t> slice;  // per k the slice of the contour set; none where it has none
};

// The image: i and j run along u and v of the first slice's plane, k along its normal; pixels lie at whole
// multiples of the pixel size from the plane's origin, slices where the contours are. Where the source's
// pixel is not known, the pixel is the median length of the contours' segments, but at least 1/1024 of the
// longer side of their box. A place between slices where one is missing gets none. Requires: a kept contour
// set. Complexity: linear in the points.
// Errors: geometry E-FLD-001 no contours, E-FLD-004 the slices are not parallel, E-FLD-005 they are not
// equidistant; limit E-FLD-006 more voxels than allowed. Warnings: W-FLD-006 slices are missing; W-FLD-013 one slice
// alone, as thick as the source says; W-FLD-015 one slice alone, of which nothing says how thick it is.
Result<SliceStack> slice_stack(const ContourSet& set, const SliceStackOptions& options, RunContext& context);

// The bit volume of the contours as a label map; in `overlaps`, when given, the voxels that lie in several
// structures: the last one holds there. Parallel over slices, same result at any thread count.
LabelMap bit_image(const ContourSet& set, const SliceStack& stack, RunContext& context,
                   std::uint64_t* overlaps = nullptr);

// The distance map of one structure, mm, in single precision; in a slice where it has no contour, the
// diagonal of the slice. Requires: structure < set.structures.size(). Parallel over slices, same result at
// any thread count.
std::vector<float> distance_image(const ContourSet& set, const SliceStack& stack, std::uint32_t structure,
                                  RunContext& context);

}  // namespace anatomesh
