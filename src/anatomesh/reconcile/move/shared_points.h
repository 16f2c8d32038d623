// Corresponding ends as groups that become one point, and that point as a common vertex of the contours.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/slices/lines/line_ends.h"

namespace anatomesh {

// Places that have to become one point: those joined by matched ends, also over several pairs (an axis
// through which many planes run). On one line they share a position along it; on several lines the point
// nearest to all is given.
struct EndGroups {
    struct Member {
        std::uint32_t group = no_node;  // no_node: in no matching
        bool pinned = false;            // several lines: the place is to move by `direction`
        double place = 0;               // position along the group's line, mm
        double sine = 0;                // of the angle between contour and line
        Vec2 direction;                 // normal of the contour times the sine, in its slice's frame
    };
    std::vector<Member> members;   // per place
    std::vector<double> position;  // per group: the mean of its places, weighed by the squared sines
    std::vector<Vec3> target;      // per group: the point; a drawn vertex where all agree within rounding
    std::vector<std::vector<Line>> lines;                      // per group: those that it lies on, distinct
    std::vector<std::vector<std::uint32_t>> slices, contours;  // per group: of its places, rising
    double worst_mm = 0;  // largest distance, across the contours, of a place from its group's point
};

EndGroups group_ends(const ContourSet& set, const EndPlaces& ends,
                     std::span<const LineComparison> comparisons, double normal_reach_mm);

struct SharedPoints {
    std::uint64_t points = 0;  // groups that became a point of all their contours
};

// Puts the groups' points into all contours that have a place of the group: a place on a vertex moves it
// there, one inside a segment splits that. Only groups whose places are within 0.05 mm of the point across
// their contours - on one line but for fewer than a third of them, slices that could not be brought there,
// which get no point -; and none that would make a slice unsound. A vertex that lies within 0.03 mm of the
// point that comes beside it gives way to it, where `moved` (of every point of the set) says that it is no
// longer as drawn: an edge so short forces cells a hundredth of the others' size. Where three slices or more
// meet in a point, those of all their pairs that are as near to each other become that one. The set's points
// and contours are laid out anew, in the same order.
SharedPoints insert_shared_points(ContourSet& set, std::span<const LineComparison> comparisons,
                                  double normal_reach_mm, const std::vector<bool>& moved);

}  // namespace anatomesh
