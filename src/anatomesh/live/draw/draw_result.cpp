#include "anatomesh/live/draw/draw_result.h"

#include <cassert>
#include <utility>

#include "anatomesh/live/draw/area/clip_area.h"

namespace anatomesh {

namespace {

AreaRule rule_of(DrawMode mode, bool begins_inside) {
    switch (mode) {
        case DrawMode::cut:
            return AreaRule::subtract;
        case DrawMode::replace:
            return AreaRule::replace;
        case DrawMode::automatic:
            return begins_inside ? AreaRule::unite : AreaRule::subtract_or_add;
        default:
            return AreaRule::unite;
    }
}

}  // namespace

DrawResult nothing_drawn(const StructureRings& before, NothingDrawn reason) {
    DrawResult drawing;
    drawing.rings = before;
    drawing.reason = reason;
    return drawing;
}

Result<DrawResult> draw_area(const StructureRings& before, std::vector<Ring> area, Vec2 start, DrawMode mode,
                             std::span<const Vec2> clip) {
    assert(mode != DrawMode::reshape);
    ANATOMESH_TRY(const ClippedArea clipped, clip_area(std::move(area), clip, before.plane));
    if (clipped.rings.empty()) {
        DrawResult drawing = nothing_drawn(before, NothingDrawn::outside);
        drawing.is_clipped = clipped.is_cut;
        return drawing;
    }
    const bool begins_inside = mode == DrawMode::automatic && lies_in(before, start);
    ANATOMESH_TRY(CombinedArea combined, combine_area(before, clipped.rings, rule_of(mode, begins_inside)));
    DrawResult drawing;
    drawing.rings = std::move(combined.rings);
    drawing.effect = combined.effect;
    if (combined.effect == AreaEffect::nothing) {
        drawing.reason = combined.is_area_empty ? NothingDrawn::no_area : NothingDrawn::nothing_there;
    }
    drawing.mended_crossings = combined.mended_crossings;
    drawing.is_clipped = clipped.is_cut;
    drawing.sliver_area_mm2 = combined.sliver_area_mm2;
    return drawing;
}

}  // namespace anatomesh
