// draw_brush: a disc of the hand's size adds to a structure where it passes, or erases.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/live/draw/area/swept_disc.h"
#include "anatomesh/live/draw/draw_result.h"

namespace anatomesh {

struct BrushOptions {
    SweptDiscOptions disc = {};
    DrawMode mode = DrawMode::extend;  // cut: an eraser. Not reshape
    std::vector<Vec2> clip = {};       // a convex polygon, the edge of the picture; empty: none
};

// Draws what the disc covers while its centre follows the path; one point is a click. Requires: sound rings.
// Guarantees: those of swept_disc() and combine_area(). Errors and complexity: theirs and those of clip_area().
Result<DrawResult> draw_brush(const StructureRings& before, std::span<const Vec2> path,
                              const BrushOptions& options);

}  // namespace anatomesh
