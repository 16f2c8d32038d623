// merge_coincident: contours of different structures that were drawn on the same line get the same vertices
// there.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/conflation_stats.h"

namespace anatomesh {

struct MergeCoincidentOptions {
    // What lies nearer to another structure's contour than this lies on it. An outline that was copied into
    // another structure comes back beside itself by what a text of two decimals rounds away (up to 0.014 mm),
    // others cross or end that near by chance; cells there would be as thin, and nobody draws that finely: a
    // pixel is 0.3 to 1 mm. [0, 0.1]; 0: contours stay as drawn
    double width_mm = 0.05;
    // But at most this share of the median segment length: contours of something tiny are no copies of each
    // other because they are small. [0, 0.5]
    double share_of_segment = 0.05;
};

struct MergeCoincidentStats : ConflationStats {
    double width_mm = 0;  // that was used
};

// Outlines that share a line but not its vertices split each other into slivers: which facet ends where is
// decided by the last digits of a file. So a vertex within the width of a vertex of another structure becomes
// that one (the nearest pairs first, the later structure's moves), and a segment within the width of another
// structure's vertex is led through it, whichever way the contours run, nested, side by side or crossing;
// what several contours share they are led through together, or not at all, but where one of them is taken
// back for itself (below). Segments that cross, seen along the normal, but pass each other in space, as
// points of a file lie off their plane by what it rounded away, are both led through the middle between them.
// A vertex that contours of several slices have moves on all of them to the same place, or stays; a structure
// is led through it on all of them, or on none. Requires: a kept contour set. Guarantees: a kept contour set
// in which every point of a contour lies within the width of where it was drawn; what is farther apart stays
// exactly as it was; no vertex is lost, and none moves but onto another one. Where contours of a structure
// would come to touch or cross one another, to turn inside out or to lie otherwise in each other, they are
// left as they were. Same result for any order of the input that led to the set. Complexity: O(n log n +
// pairs nearer than the width) a slice, times the rounds of taking back what does not serve (one as a rule),
// times those of what slices with common vertices differ in (few; at most 17, then such vertices stay as they
// are).
MergeCoincidentStats merge_coincident(ContourSet& set, const MergeCoincidentOptions& options);

}  // namespace anatomesh
