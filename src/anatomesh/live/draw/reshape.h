// reshape_outline: a line of the hand in the place of a stretch of an outline.
#pragma once

#include <span>

#include "anatomesh/live/draw/draw_result.h"

namespace anatomesh {

// The line begins and ends on an outline. At either end it is joined to the ring nearest to its first point: where it
// meets the ring within `reach_mm` of that end along the line; else at the foot of that end, if it is that near; else
// where the line first meets the ring. It takes the place of the stretch between that encloses the smaller area with it,
// as the correction tools of contouring programs do: what changes least is what was meant. Where the new outline bounds
// more than before, that is added to the structure, also over other rings, and within `clip` alone; where it bounds less,
// that is taken away. At a hole it is the other way round. The rest of the ring keeps its vertices.
// Nothing is drawn, with NothingDrawn::no_outline, where an end is near no outline or the ends are joined to one point.
// Requires: sound rings, a line of finite points without two equal ones in turn. Errors: those of clip_area(), and limit
// E-LIV-007 the edges cross too often. Complexity: O(points of the line x edges of a ring), and that of arrange().
Result<DrawResult> reshape_outline(const StructureRings& before, std::span<const Vec2> line, double reach_mm,
                                   std::span<const Vec2> clip);

}  // namespace anatomesh
