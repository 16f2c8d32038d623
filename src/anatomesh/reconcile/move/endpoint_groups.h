// group_endpoints: endpoints of several slices that have to become one point, and that point.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// Places that have to become one point: those that matched endpoints join, over several pairs too (an axis
// of many planes). On one line they share a position along it. On several lines the point nearest to all
// is their target.
struct EndpointGroups {
    struct Member {
        std::uint32_t group = no_node;  // no_node: in no matching
        bool pinned = false;            // several lines: the place is to move by `direction`
        double place = 0;               // position along the group's line, mm
        double sine = 0;                // of the angle between contour and line
        Vec2 direction;                 // normal of the contour times the sine, in its slice's frame

        double weight() const;  // in means of places: the squared sine, and a little, above 0
    };
    std::vector<Member> members;   // per place
    std::vector<double> position;  // per group: the mean of its places, weighed by the squared sines
    std::vector<Vec3> target;      // per group: the point; a drawn vertex where all agree within rounding
    std::vector<std::vector<Line>> lines;                      // per group: those that it lies on, distinct
    std::vector<std::vector<std::uint32_t>> slices, contours;  // per group: of its places, rising
    double worst_mm = 0;  // largest distance, across the contours, of a place from its group's point
};

// Groups the places. O(places log places + endpoints).
EndpointGroups group_endpoints(const ContourSet& set, const EndpointPlaces& ends,
                               std::span<const LineComparison> comparisons);

// Adds to `distinct` the lines that are not in it yet, two lines within rounding being one. O(lines *
// distinct).
void add_lines(std::span<const Line> lines, std::vector<Line>& distinct);

// Gives the point nearest to all lines, in the sense of least squares; false where the lines are nearly
// parallel to each other. `near`: a place near to them, for the sake of rounding. O(lines).
bool meeting_point(std::span<const Line> lines, Vec3 near, Vec3& point);

}  // namespace anatomesh
