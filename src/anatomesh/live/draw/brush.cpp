#include "anatomesh/live/draw/brush.h"

#include <utility>

#include "anatomesh/base/standard_arithmetic.h"

namespace anatomesh {

Result<DrawResult> draw_brush(const StructureRings& before, std::span<const Vec2> path,
                              const BrushOptions& options) {
    const StandardArithmetic arithmetic;
    if (path.empty()) return nothing_drawn(before, NothingDrawn::too_short);
    ANATOMESH_TRY(std::vector<Ring> area, swept_disc(path, before.plane, options.disc));
    return draw_area(before, std::move(area), path[0], options.mode, options.clip);
}

}  // namespace anatomesh
