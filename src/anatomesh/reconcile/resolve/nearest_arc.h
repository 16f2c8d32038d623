// nearest_arc: the part of a slice's contour that has to come over a line if the slice is to have what
// others have there.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/lines/arc.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// A part of a contour that runs along a line in its plane, on one side of it and nowhere steeper than 60
// degrees. Its points are those beside the interval and may be none; its height is that of its places,
// too.
struct NearestArc : Arc {
    // Where the contour lies beside the interval's ends and its middle, as far as the arc reaches; none
    // where it has a point.
    std::vector<IntervalEndpoint> places;  // none at a point, which is there

    bool empty() const { return points.empty() && places.empty(); }
};

// Returns the arc of a structure's contours on slice `own` that is nearest to the interval from `low` to
// `high` of the slice's common line with another one. From there it goes both ways as long as the contour
// runs on along the line, beside the interval, and does not pass the line. The arc is empty where nothing
// lies beside the interval. Requires: low < high. O(points of the slice's contours).
NearestArc nearest_arc(const ContourSet& set, std::uint32_t own, std::uint32_t structure, const Line& line,
                       const Plane& other, double low, double high);

}  // namespace anatomesh
