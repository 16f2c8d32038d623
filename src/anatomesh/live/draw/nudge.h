// nudge_outline: a disc pushes the outline of a structure before it.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/live/draw/area/swept_disc.h"
#include "anatomesh/live/draw/draw_result.h"

namespace anatomesh {

struct NudgeOptions {
    SweptDiscOptions disc = {10, 0.05};
    double pixel_mm = 0.5;        // of the picture; new vertices keep 0.15 of it apart. [0.001, 100]
    std::vector<Vec2> clip = {};  // a convex polygon, the edge of the picture; empty: none
};

// A nudge that begins inside the structure pushes the outline outwards: it unites the structure with what the disc
// covers. One that begins outside pushes inwards: it takes that away. So an outline never folds, and what the disc does
// not cover keeps its vertices. Pieces smaller than the disc that the sweep cuts off a ring, or closes off outside of
// it, go with it where no ring lies in them: a nudge makes no new ring of them. So do triangles that are
// left of a ring where a vertex is nearer than 0.15 pixel to the next. New vertices nearer than 0.15 pixel to
// the next vertex are left out where no line crosses the cut, and new edges are at most as long as the longest edge
// before. Requires: sound rings. Guarantees: sound rings, within the convex hull of ring and sweep. Errors: those of
// swept_disc() and draw_area(). Complexity: that of draw_brush(), and O(new vertices x vertices).
Result<DrawResult> nudge_outline(const StructureRings& before, std::span<const Vec2> path,
                                 const NudgeOptions& options);

}  // namespace anatomesh
