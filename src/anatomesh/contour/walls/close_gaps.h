// close_gaps: neighbouring structures whose contours run side by side get one wall in common.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/conflation_stats.h"

namespace anatomesh {

struct CloseGapsOptions {
    double width_mm = 0;  // gaps and overlaps narrower than this are closed; about a pixel. 0: none. [0, 10]
};

// Contours of two structures may run beside each other in opposite directions, with a gap or an overlap narrower
// than the width between them. Both are then led through the vertices of both, so that a stretch of one is a stretch
// of the other, edge for edge. Left alone are contours that run in the same direction, because they are the two sides
// of a wall between nested contours. Left alone are also lone vertices, and what lies beyond another contour.
// Requires: a kept contour set. Guarantees: a kept contour set. No vertex moves and none is lost. Contours of a
// structure stay as they were where they would touch or cross one another, turn inside out, or change their nesting.
// The result is the same for any order of the input that led to the set. Complexity: O(n log n + pairs nearer than
// the width) a slice, times the rounds of taking back (2 or 3 as a rule).
ConflationStats close_gaps(ContourSet& set, const CloseGapsOptions& options);

}  // namespace anatomesh
