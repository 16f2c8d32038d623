// nearest_arc: the part of a slice's contour that has to come over a line for the slice to have there what
// others have.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/lines/arc.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// A part of a contour as seen from a line in its plane: it runs along the line on one side of it, nowhere
// steeper than 60 degrees.
struct NearestArc : Arc {  // its points: those beside the interval, may be none; its height: of `places`, too
    // Where the contour lies beside the interval's ends and its middle, as far as the stretch reaches.
    std::vector<IntervalEndpoint> places;  // none at a point, which is there

    bool empty() const { return points.empty() && places.empty(); }
};

// Of the contours of a structure on slice `own`, on its common line with another slice: the stretch nearest
// to the interval from `low` to `high` along the line, from there both ways for as long as it runs on along
// the line, beside the interval, and does not pass the line. Without points and places where nothing lies
// beside the interval. Requires: low < high. O(points of the slice's contours).
NearestArc nearest_arc(const ContourSet& set, std::uint32_t own, std::uint32_t structure, const Line& line,
                       const Plane& other, double low, double high);

}  // namespace anatomesh
