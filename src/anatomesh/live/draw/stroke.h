// draw_stroke and draw_polygon: a line of the hand, or corners that it set, extend, cut, replace or reshape a structure.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/live/draw/draw_result.h"

namespace anatomesh {

struct StrokeOptions {
    DrawMode mode = DrawMode::automatic;
    double tolerance_mm = 0.05;  // the hand's points stay within this of the line that is used. [0.001, 10]
    double pixel_mm = 0.5;  // of the picture: a stroke that stays within 3 pixels is a click. [0.001, 100]
    double reach_mm = 2;    // reshape: how near an outline the stroke begins and ends. [0, 1000]
    std::vector<Vec2> clip = {};  // a convex polygon, the edge of the picture; empty: none
};

// Draws the area that the stroke encloses; its last point is joined to its first. Where its end meets
// its beginning, both tails are cut off there if they are 15 % of its length together at most. Where the end passes the
// beginning by within 15 % of the length, it ends beside it. An area
// that crosses itself is mended by the even-odd rule. With DrawMode::reshape the stroke is a line: see reshape_outline()
// (reshape.h). Requires: sound rings. Guarantees: those of combine_area(). Errors: those of check_points(),
// check_option() and draw_area(). Complexity: those of thin_line() and draw_area().
Result<DrawResult> draw_stroke(const StructureRings& before, std::span<const Vec2> stroke,
                               const StrokeOptions& options);

// Draws a polygon through its corners, all of which become vertices but where another line takes their place. Its tails
// are not cut off, and no corner is dropped. The mode is not reshape. Else as draw_stroke().
Result<DrawResult> draw_polygon(const StructureRings& before, std::span<const Vec2> corners, DrawMode mode,
                                std::span<const Vec2> clip = {});

// Returns the closed polygon that a line of the hand means: without the tails that cross, as draw_stroke() says.
// Complexity: O(n log n) for tails that meet rarely.
std::vector<Vec2> without_tails(std::span<const Vec2> line);

}  // namespace anatomesh
