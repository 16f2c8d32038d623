// One slice as the paper's Fig. 2 shows it: the contours beside their distance map.
#pragma once

#include <string>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Two pictures (SVG) side by side, of the structure and slice with the most contour points, with a caption;
// empty without contours. The distance is that of the raster of field/slice/distance_raster.h, at most 96 points
// wide or high, in steps of a sixteenth of the largest one inside or outside. Below 200 kB.
std::string slice_figure(const ContourSet& contours);

}  // namespace anatomesh
