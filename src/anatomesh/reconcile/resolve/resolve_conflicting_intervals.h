// resolve_conflicting_intervals: slices that still differ on an interval of their common line come to
// agree by a small change of one of them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/original_positions.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

struct ConflictingIntervalOptions {
    // So much is added or removed on either side of the line, and less for short intervals. Nearer to the
    // line two planes are so close to each other that no cells of any shape fit between. mm, above 0
    double clearance_mm = 0.5;
    // No contour changes further than this, nor further than three times the interval or the clearance.
    // mm, above 0
    double most_mm = 10;
    // Contours are parted or joined only over intervals up to this length, about two segments: whoever
    // drew it saw what is wider. mm, above 0
    double most_parted_mm = 10;
};

// A structure of a slice that was changed for the sake of another slice.
struct ResolvedInterval {
    std::uint32_t slice = 0, structure = 0, other = 0;
    bool inside = false;     // whether the structure came to have the interval, or lost it
    bool parts = false;      // whether contours were parted or joined, or came or went as a whole
    double length_mm = 0;    // of the interval
    double farthest_mm = 0;  // of the contours from where they were
};

// The comparisons of a set's slices, in their order.
using CompareSlices = std::function<std::vector<LineComparison>(const ContourSet&)>;

// On a conflicting interval of a common line one slice is inside a structure and the other one outside. One
// of the two is changed there: the structure is added to it, or removed from it, up to the clearance beside
// the line. A part of the contour that this cuts off is removed too, or stays as a contour of its own. A gap
// to the contour beside the interval is closed. Of these changes the smallest is taken.
//
// Which slice changes is decided in this order. Where most slices through the line agree with each other,
// the one that contradicts them changes. Where one of the two differs from more slices than the other
// does, that one changes: a wrong slice does not change all that are right. Otherwise it is the slice that
// has to change less. Where most slices have the interval and no contour is near enough to come there, the
// interval becomes a contour of its own.
//
// A change is kept if all slices together differ by less afterwards, by at least half of the interval.
// Intervals shorter than 0.01 mm stay. `drawn` is kept up: the original position of a new point is where
// it was put.
//
// Requires: a kept contour set, `comparisons` of it. Guarantees: a kept contour set again, by exact
// predicates; nothing changes where slices agree. Returns what was changed, in order. The result is the
// same every time. Complexity: a comparison of all slices for each change. No earlier method is followed.
std::vector<ResolvedInterval> resolve_conflicting_intervals(ContourSet& set, OriginalPositions& drawn,
                                                            std::vector<LineComparison> comparisons,
                                                            const CompareSlices& compare,
                                                            const ConflictingIntervalOptions& options,
                                                            RunContext& context);

}  // namespace anatomesh
