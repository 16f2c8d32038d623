// close_gaps: neighbouring structures whose contours run side by side get one wall in common.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/conflation_stats.h"

namespace anatomesh {

struct CloseGapsOptions {
    double width_mm = 0;  // gaps and overlaps narrower than this are closed; about a pixel. 0: none. [0, 10]
};

// Where contours of two structures run beside each other in opposite directions, with a gap or an overlap
// narrower than the width between them, both are led through the vertices of both: a stretch of the one is
// then a stretch of the other, edge for edge. No vertex moves and none is lost. Left alone are contours that
// run in the same direction, as the two sides of a wall between nested contours do, what lies beyond another
// contour, and lone vertices. Requires: a kept contour set. Guarantees: a kept contour set: where contours of
// a structure would come to touch or cross one another, to turn inside out or to lie otherwise in each other,
// they are left as they were. Same result for any order of the input that led to the set. Complexity: O(n log
// n + pairs nearer than the width) a slice, times the rounds of taking back what does not serve (2 or 3 as a
// rule).
ConflationStats close_gaps(ContourSet& set, const CloseGapsOptions& options);

}  // namespace anatomesh
