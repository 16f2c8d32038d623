// closed_spline and draw_spline: a smooth closed line through points that the hand sets and moves.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/live/draw/draw_result.h"

namespace anatomesh {

struct SplineOptions {
    DrawMode mode = DrawMode::automatic;
    double tolerance_mm = 0.05;   // the polygon stays within this of the curve. [0.001, 10]
    std::vector<Vec2> clip = {};  // a convex polygon, the edge of the picture; empty: none
};

// Returns a polygon within `tolerance_mm` of the closed centripetal Catmull-Rom curve through the controls. It begins at the
// first control and has each control as a vertex, bit for bit. The stretch between two controls depends on these and
// on the next one on either side alone, so a control that moves leaves all beyond two controls from it bit for bit. A
// control equal to the one before does not count, nor does a last one equal to the first; fewer than three are returned
// as they are. Requires: finite controls, tolerance_mm > 0. O(vertices of the result).
// Source: Yuksel, Schaefer and Keyser, Computer-Aided Design 43, 2011 (alpha = 1/2); Barry and Goldman, SIGGRAPH 1988
// (evaluation).
std::vector<Vec2> closed_spline(std::span<const Vec2> controls, double tolerance_mm);

// Draws the area in the spline, as draw_polygon() (stroke.h) does: a curve that crosses itself is mended by the even-odd
// rule. Requires: sound rings; the mode is not reshape. Errors: those of check_points(), check_option(), draw_area().
Result<DrawResult> draw_spline(const StructureRings& before, std::span<const Vec2> controls,
                               const SplineOptions& options);

}  // namespace anatomesh
