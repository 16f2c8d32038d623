// close_slivers: a wall that was drawn once for each of two structures becomes one wall.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/conflation_stats.h"

namespace anatomesh {

struct CloseSliversOptions {
    double width_mm = 0.4;  // slivers narrower than this are closed; about a pixel. 0: none. [0, 10]
    // The width is at most this share of the mean segment length in the sliver, of either contour. What is wider is
    // drawn finely enough to be meant, and a mesh with edges as long as its segments can hold it. [0, 0.5]; 0: none
    double share_of_segment = 0.1;
    // The slivers of a structure on a slice stay if together they change its area by more than this share of it.
    // [0, 1]
    double most_of_area = 0.02;
};

// Two contours that run in opposite directions may meet (cross, or have a vertex in common) and soon meet again. One
// wall was then drawn twice, each time with its own few vertices, and the sliver between the meetings was not meant.
// A sliver is closed if it has at most three vertices of either contour, each nearer to the other contour than the
// width. Both contours are led through the vertices of both, in one order. Where slivers that follow one another end
// in a crossing, it becomes a vertex of both contours, so that nothing changes beyond it. A crossing within a tenth of
// a segment of its end is that end instead, if this changes at most a tenth of the slivers' area.
// These stay as drawn:
// - what is open on one side, as the gap of a joint is,
// - what has more vertices than three,
// - what lies behind another contour, or in a third structure on one side alone,
// - contours that run in the same direction,
// - what another slice passes through within the box of its contours, because slices that agree as drawn would not
//   agree afterwards; a common vertex at the sliver's end is allowed.
// Requires: a kept contour set. Guarantees: those of close_gaps(): a kept contour set, and no drawn vertex moves or is
// lost. Complexity: O(n log n + pairs of segments whose boxes meet + slivers times slices) a slice.
// Source: the spurious polygons of overlaid maps, M. F. Goodchild, "Statistical aspects of the polygon overlay
// problem", in: G. Dutton (ed.), Harvard Papers on Geographic Information Systems 6, 1978.
ConflationStats close_slivers(ContourSet& set, const CloseSliversOptions& options);

}  // namespace anatomesh
