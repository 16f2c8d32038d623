// split_encroached_subsegments: contour segments split as finely as the contours beside them ask.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/sample/contour_segments.h"
#include "anatomesh/sample/protected_segments.h"

namespace anatomesh {

struct EncroachmentOptions {
    double shortest_mm = 0;  // no subsegment below it. > 0
    // By point, or empty. Then those alone count that lie in the subsegment's slice and on no contour of its
    // structures: what keeps apart that runs side by side within slices, and leaves the rest as it is.
    std::vector<std::uint32_t> slices;
    // With slices, if not 0: no subsegment is longer than so many times the distance of any vertex in its
    // slice from it, but next to where subsegments meet at a small angle; down to shortest_mm, then, step by
    // step, to shortest_graded_mm (> 0), until there are more than `most_added` new points for each that
    // there was. > 2
    double growth = 0;
    double shortest_graded_mm = 0;
    double most_added = 2;
    int threads = 1;
};

// Splits subsegments until no other contour's vertex lies in the ball of one: then all are edges of the
// Delaunay mesh of these points, and stay so as long as free points keep out of the balls. About an axis in
// which planes meet, contours run close beside each other far from any common vertex, and subsegments become
// as short as they are near. Where contours run hundredths of a millimetre beside each other or cross near a
// vertex, or at a small angle, `growth` makes lengths follow the distance, so that cells there can be about
// as wide as long. Nearer to where they cross than lengths can follow, subsegments are split at the feet of
// each other's vertices (foot_on()). A vertex nearer to a subsegment than half the shortest length is left in
// its ball: no split above that length takes it out, but for one on another way from the same apex.
// Subsegments that come from where some meet at acute angles (SegmentClusters) are split on concentric
// shells. No point is put nearer than half the shortest length to another one, unless both are on one shell.
// `points` are those on contours, as `protected_segments` has them; new ones are appended, and both know the
// halves. Returns how many. At most 24 rounds; complexity: O(n) each beside the points in balls. The same
// result every time. Follows: Shewchuk, Delaunay refinement mesh generation, 1997, chapters 3 and 4.
std::size_t split_encroached_subsegments(std::vector<Vec3>& points, std::vector<Subsegment>& subsegments,
                                         ProtectedSegments& protected_segments,
                                         const EncroachmentOptions& options);

}  // namespace anatomesh
