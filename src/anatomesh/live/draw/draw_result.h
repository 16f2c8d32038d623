// DrawResult: what a tool of the hand did to the rings of a structure on a plane, for all tools of this room.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/live/draw/area/combine_area.h"

namespace anatomesh {

enum class DrawMode : std::uint8_t {
    automatic,  // extend for what begins in the structure, else cut; where it meets nothing, a part of its own
    extend,     // united with the structure
    cut,        // taken from the structure
    replace,    // in the place of the parts of the structure that it overlaps
    reshape     // a line in the place of a stretch of an outline; of strokes alone
};

// Why nothing was drawn. These are no errors: a hand does so every day.
enum class NothingDrawn : std::uint8_t {
    none,           // something was drawn
    too_short,      // a click, or a jitter of the hand
    no_area,        // what was drawn encloses nothing
    outside,        // all of it lies outside the clip
    no_outline,     // a line that was to reshape an outline begins or ends near none, or near two
    nothing_there,  // it changes nothing: the structure is not there, or is as drawn already
};

struct DrawResult {
    StructureRings rings;                      // of the structure afterwards
    AreaEffect effect = AreaEffect::nothing;   // what became of the structure
    NothingDrawn reason = NothingDrawn::none;  // why the effect is nothing
    std::uint32_t mended_crossings = 0;        // of the drawn line with itself; the even-odd rule mended them
    bool is_clipped = false;                   // a part of what was drawn lay outside the clip
    std::uint32_t dropped_pieces = 0;          // by a nudge: small pieces that it cut off or closed off
    double sliver_area_mm2 = 0;                // of rings that only rounding made; left out
};

// Combines a drawn area with the structure. `start` is the point at which the hand began, for DrawMode::automatic.
// Requires: sound rings; the mode is not reshape. Errors: those of clip_area() and combine_area(). Complexity: theirs.
Result<DrawResult> draw_area(const StructureRings& before, std::vector<Ring> area, Vec2 start, DrawMode mode,
                             std::span<const Vec2> clip);

// The drawing that leaves everything as it was.
DrawResult nothing_drawn(const StructureRings& before, NothingDrawn reason);

}  // namespace anatomesh
