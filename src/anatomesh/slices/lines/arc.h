// arc_between: the part of a contour that another slice's plane cuts off.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// A contour runs along a line as long as it is not steeper than this, height over length: 60 degrees.
// [1; > 0; M 2026-11, set not recorded]
inline constexpr double steepest_along_line = 1.732;

// The part of a contour between two ends, on one side of the other slice's plane.
struct Arc {
    std::vector<std::uint32_t> points;  // of the set, in order; empty: there is no such part
    std::vector<double> heights_mm;     // their distances from the common line
    double height_mm = 0;               // the largest
    Vec2 back;  // unit vector across the line, away from the arc, in the slice's frame
};

// The lower of the two parts of the contour between p and q that keep to one side of `other`; none when the
// ends lie on different contours, or both parts pass the plane again. O(points of the contour).
Arc arc_between(const ContourSet& set, const IntervalEndpoint& p, const IntervalEndpoint& q, const Plane& own,
                const Plane& other);

}  // namespace anatomesh
