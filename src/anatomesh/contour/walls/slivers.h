// close_slivers: a wall that was drawn once for each of two structures becomes one.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/conflation_stats.h"

namespace anatomesh {

struct CloseSliversOptions {
    double width_mm = 0.4;  // slivers narrower than this are closed; about a pixel. 0: none. [0, 10]
    // But at most this share of the mean segment length in the sliver, of either contour: what is wider is
    // drawn finely enough to be meant, and a mesh whose edges are as long as its segments can hold it.
    // [0, 0.5]; 0: none
    double share_of_segment = 0.1;
    // Slivers that change a structure's area on a slice by more than this share of it, all together, stay.
    // [0, 1]
    double most_of_area = 0.02;
};

// Where two contours that run in opposite directions meet (cross, or have a vertex in common) and meet again
// soon, one wall was drawn twice, each time with its own few vertices; what lies between the one meeting and
// the next, a sliver, was not meant. Closed is what has at most three vertices of either contour, each nearer
// to the other contour than the width: from its first meeting to its last one both contours are led through
// the vertices of both, in one order. The crossings at the ends of slivers that follow one another become
// vertices of both contours, so that nothing changes beyond them; a crossing within a tenth of a segment of
// its end is that end instead, where no more than a tenth of the slivers' area changes for it. No drawn
// vertex moves and none is lost. Left as drawn is what is open on one side, as the gap of a joint; what is
// longer than those vertices; what lies behind another contour, or in a third structure on one side alone;
// contours that run in the same direction; and what another slice passes through (within the box of its
// contours) elsewhere than in a common vertex at its end, which stays: slices that agree as drawn would not
// afterwards. Requires: a kept contour set. Guarantees: a
// kept contour set, as close_gaps() does. Complexity: O(n log n + pairs of segments whose boxes meet +
// slivers times slices) a slice. Source of the notion: the spurious polygons of overlaid maps, M. F.
// Goodchild, "Statistical aspects of the polygon overlay problem", in: G. Dutton (ed.), Harvard Papers on
// Geographic Information Systems 6, 1978.
ConflationStats close_slivers(ContourSet& set, const CloseSliversOptions& options);

}  // namespace anatomesh
