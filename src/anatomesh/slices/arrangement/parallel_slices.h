// Slices that are parallel: their places along the common normal.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

// A slice as an interval along the common normal: contour points may lie off their plane by the reader's
// tolerance, and on all of them the slice's own region must hold.
struct SliceInterval {
    std::uint32_t slice = 0;
    double low = 0, high = 0;
};

inline double middle(const SliceInterval& interval) {
    return 0.5 * (interval.low + interval.high);
}

// The slices of a set in rising order along `frame`'s normal, or nothing when they are not parallel: when one
// is thicker than a tenth of its distance to the next, or two overlap.
std::vector<SliceInterval> parallel_intervals(const ContourSet& set, const Plane& frame);

// Whether the slices are parallel and apart.
bool is_parallel(const ContourSet& set);

}  // namespace anatomesh
