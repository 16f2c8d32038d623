// resolve_conflicting_intervals: slices that still differ on a piece of their common line come to agree by a
// small change of one of them.
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
    // Beside the line so much is given or taken, less for short pieces: nearer to it two planes are so close
    // to each other that no cells of any shape fit between. mm, above 0
    double clearance_mm = 0.5;
    // No contour changes further than this, nor than three times the piece or the clearance. mm, above 0
    double most_mm = 10;
    // Contours are parted or joined over pieces up to this length alone, about two segments: what is wider
    // was seen by whoever drew it. mm, above 0
    double most_parted_mm = 10;
};

// A structure of a slice that was changed for the sake of another slice.
struct ResolvedInterval {
    std::uint32_t slice = 0, structure = 0, other = 0;
    bool inside = false;     // whether the structure came to have the piece, or lost it
    bool parts = false;      // whether contours were parted or joined, or came or went as a whole
    double length_mm = 0;    // of the piece of the line
    double farthest_mm = 0;  // of the contours from where they were
};

// The comparisons of a set's slices, in their order.
using CompareSlices = std::function<std::vector<LineComparison>(const ContourSet&)>;

// On each piece of a common line that one slice has inside a structure and the other outside, one of the two
// is changed beside the line: it gives the piece away, or gets it, with what is nearer to the line than the
// clearance. What that cuts off from the contour goes as well, or stays as a part of its own, and a gap to
// the contour beside the piece is closed, whichever changes the contours least; and of the two slices it is
// the one that changes less. But where most of the slices through the line have it otherwise it is the slice
// that they contradict, and where one slice differed from more slices than the other did, it is that one: a
// slice that is wrong does not change all that are right. Where most have it and no contour is near enough to
// come there, the piece becomes a part of its own. A change is kept if all slices together differ by less
// afterwards, by at least half of the piece. Pieces shorter than 0.01 mm stay. `drawn` is kept up: what was
// put in was drawn where it is.
//
// Requires: a kept contour set, `comparisons` of it. Guarantees: a kept contour set again, by exact
// predicates; nothing changes where slices agree. Returns what was changed, in order. Deterministic.
// Complexity: a comparison of all slices for each change. No earlier method is followed.
std::vector<ResolvedInterval> resolve_conflicting_intervals(ContourSet& set, OriginalPositions& drawn,
                                                            std::vector<LineComparison> comparisons,
                                                            const CompareSlices& compare,
                                                            const ConflictingIntervalOptions& options,
                                                            RunContext& context);

}  // namespace anatomesh
