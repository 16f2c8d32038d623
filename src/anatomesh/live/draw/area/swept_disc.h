// swept_disc: the area that a disc covers while its centre follows a path, for brush, eraser and nudge.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/live/draw/area/structure_rings.h"

namespace anatomesh {

struct SweptDiscOptions {
    double radius_mm = 5;        // of the disc. [0.01, 1000]
    double tolerance_mm = 0.05;  // the outline is within this of the exact one. [0.001, 10]
};

// Returns the boundary of the union of all discs along the path: one outer ring, counter-clockwise, then the holes that
// the path goes around, clockwise. A path of one point is a click. The disc is a regular polygon of its area, and the
// area is that of the Minkowski sum of polygon and path, exactly but for the rounding of vertices. The path loses points
// first: of the tolerance, half is for this, a quarter for the polygon. The rings keep apart from each other and are
// simple; they depend on the path's points alone, so a path that goes there and back covers what one way covers.
// Requires: a path of one point or more. Errors: those of check_points(), check_option() and crosses_too_often().
// Method: the boundary consists of edges of the convolution of the path, run there and back, with the polygon. The winding
// number of the convolution at a point is the number of stretches of the path that the disc around it meets (Guibas,
// Ramshaw and Stolfi, FOCS 1983; Chen and McMains, ASME DETC 2005). Stretches of the convolution within the sum of one
// edge of the path and the polygon are replaced by their chords first. Complexity: O(n w) for n points and a fixed
// number w of edges looked at, and that of arrange() for what is left.
Result<std::vector<Ring>> swept_disc(std::span<const Vec2> path, const Plane& plane,
                                     const SweptDiscOptions& options);

}  // namespace anatomesh
