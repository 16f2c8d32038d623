// restore_areas: outlines that hold the area of their pixels.
//
// A boundary through the middles of pixel edges cuts an eighth of a pixel off every corner, so that an outline lacks half
// a pixel, whatever its size, and a hole too. Leaving vertices out changes its area again.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/contour/trace/trace_slice.h"

namespace anatomesh {

// Moves the kept points of the network, in pixel coordinates, by the least squares that give each ring of kept points
// the area of its pixels. What rings share stays shared. `epsilon`: the bound in pixels within which points were left out.
// Requires: a grid that was traced without grey values, with its points as they were traced.
//
// Guarantees: a point moves by 0.3 pixel or epsilon at most, and always by less than half the distance to what it could meet.
// So no ring crosses or touches another one or itself on the way. No pixel centre changes sides while epsilon is below
// 0.35. Where that leaves too little room, areas come as near as they can. A connected piece of boundary moves by itself;
// others matter to it only where they are near. Complexity: expected O(points) in each of few rounds.
// Source: the least change under constraints of area, by Lagrange's multipliers and Newton's method; the multipliers by
// conjugate gradients (Hestenes and Stiefel, J. Res. NBS 49, 1952).
void restore_areas(TracedGrid& traced, std::span<const std::uint8_t> kept, double epsilon);

}  // namespace anatomesh
