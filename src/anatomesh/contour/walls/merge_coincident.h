// merge_coincident: contours of different structures that were drawn on the same line get the same vertices there.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/conflation_stats.h"

namespace anatomesh {

struct MergeCoincidentOptions {
    // A vertex nearer to another structure's contour than this lies on it. An outline that was copied into another
    // structure comes back beside itself by what a text of two decimals rounds away, up to 0.014 mm. Cells there
    // would be as thin, and nobody draws that finely, because a pixel is 0.3 to 1 mm. [0, 0.1]; 0: contours stay as
    // drawn
    double width_mm = 0.05;
    // The width is at most this share of the median segment length, because small contours are no copies of each
    // other for being small. [0, 0.5]
    double share_of_segment = 0.05;
};

struct MergeCoincidentStats : ConflationStats {
    double width_mm = 0;  // that was used
};

// Outlines that share a line but not its vertices split each other into slivers; the last digits of a file would
// decide which facet ends where. Three things make them one:
// - A vertex within the width of a vertex of another structure becomes that one. The nearest pairs come first, and
//   the later structure's vertex moves.
// - A segment within the width of another structure's vertex is led through it, whichever way the contours run.
//   Contours that share a segment are led together, or not at all.
// - Points of a file lie off their plane by what it rounded away, so segments may cross, seen along the normal, and
//   pass each other in space. Both are then led through the middle between them.
// A vertex that contours of several slices have moves on all of them to the same place, or stays. A structure is led
// through it on all of them, or on none.
// Requires: a kept contour set. Guarantees: a kept contour set in which every point of a contour lies within the
// width of where it was drawn. What is farther apart stays exactly as it was. No vertex is lost, and each moves only
// onto another one. Contours of a structure stay as they were where they would touch or cross one another, turn
// inside out, or change their nesting. The result is the same for any order of the input that led to the set.
// Complexity: O(n log n + pairs nearer than the width) a slice and round. There is one round of taking back as a rule,
// and few rounds, at most 17, in which slices with common vertices agree.
MergeCoincidentStats merge_coincident(ContourSet& set, const MergeCoincidentOptions& options);

}  // namespace anatomesh
