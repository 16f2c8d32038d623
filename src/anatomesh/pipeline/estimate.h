// How large a model will be, from its contours and the edge length asked for, before it is built.
#pragma once

#include <cstdint>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// About as many tetrahedra; right within a factor of three or so. Their number goes with the area of the
// surface over the square of the edge length, for they grow with the depth, and is at most what the volume
// holds of that size. 0 when the contours do not show how far apart their slices are. Requires: size_mm > 0.
// Linear in the points.
double estimated_tetrahedra(const ContourSet& contours, double size_mm);

struct SizeLimits {
    std::uint64_t tetrahedra = 0;    // > 0
    std::uint64_t memory_bytes = 0;  // of the whole run; 0: not known, and no reason to refuse a model
};

// Error: limit E-CMD-014, more tetrahedra or memory than the limits allow. Requires: size_mm > 0.
Status check_size(const ContourSet& contours, double size_mm, const SizeLimits& limits);

// Where slices lie far closer than the contours' vertices the default edge length follows the slices, and a
// flat thing would need a huge model that nobody asked for. Error: limit E-CMD-014, above ten million
// tetrahedra.
Status check_default_size(const ContourSet& contours);

}  // namespace anatomesh
