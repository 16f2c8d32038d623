// close_gaps: neighbouring structures whose contours run side by side get one wall in common.
#pragma once

#include <cstdint>

#include "anatomesh/contour/contour_set.h"

namespace anatomesh {

struct CloseGapsOptions {
    double width_mm = 0;  // gaps and overlaps narrower than this are closed; about a pixel. 0: none. [0, 10]
};

class LedContours;

struct CloseGapsStats {
    std::uint64_t vertices_taken = 0;  // by a contour from its neighbour's
    std::uint64_t contours_changed = 0;
    std::uint32_t slices = 0;       // where something was closed
    std::uint32_t worst_slice = 0;  // the one with the widest of them
    double widest_mm = 0;           // of a vertex taken from the segment that was led through it
    double area_mm2 = 0;            // between contours as drawn and as led, over all slices and contours

    // What was changed on a slice.
    void add(const LedContours& led, std::uint32_t slice);
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
CloseGapsStats close_gaps(ContourSet& set, const CloseGapsOptions& options);

}  // namespace anatomesh
