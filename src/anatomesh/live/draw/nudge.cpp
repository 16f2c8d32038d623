#include "anatomesh/live/draw/nudge.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "anatomesh/base/standard_arithmetic.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/live/draw/area/clip_area.h"
#include "anatomesh/live/draw/area/tool_ranges.h"
#include "anatomesh/live/draw/space_vertices.h"

namespace anatomesh {

namespace {

// New vertices keep this share of a pixel apart. [pixels; 0 to 1; C]
constexpr double least_spacing_pixels = 0.15;

// Whether a vertex of another ring lies in the ring.
bool has_ring_in_it(const std::vector<Ring>& rings, std::size_t ring) {
    for (std::size_t r = 0; r < rings.size(); ++r) {
        if (r == ring) continue;
        const std::vector<Vec2>& at = rings[r].at;
        if (std::any_of(at.begin(), at.end(),
                        [&](Vec2 p) { return side_of_polygon(rings[ring].at, p) == Side::inside; })) {
            return true;
        }
    }
    return false;
}

// Whether each ring is the largest of those that came from the same ring.
std::vector<char> largest_pieces(const CombinedArea& combined, std::size_t rings_before) {
    std::vector<char> is_largest(combined.came_from.size(), 0);
    std::vector<std::size_t> largest(rings_before, combined.came_from.size());
    for (std::size_t r = 0; r < combined.came_from.size(); ++r) {
        if (combined.came_from[r] < 0) continue;
        std::size_t& best = largest[static_cast<std::size_t>(combined.came_from[r])];
        const auto area = [&](std::size_t k) { return std::abs(signed_area(combined.rings.rings[k].at)); };
        if (best == combined.came_from.size() || area(r) > area(best)) best = r;
    }
    for (const std::size_t r : largest) {
        if (r < is_largest.size()) is_largest[r] = 1;
    }
    return is_largest;
}

void drop(std::vector<Ring>& rings, std::size_t r, std::uint32_t& dropped) {
    rings.erase(rings.begin() + static_cast<std::ptrdiff_t>(r));
    ++dropped;
}

// Drops what was cut off or closed off and is smaller than the disc.
void drop_small_pieces(CombinedArea& combined, std::size_t rings_before, double disc_area,
                       std::uint32_t& dropped) {
    const std::vector<char> is_largest = largest_pieces(combined, rings_before);
    std::vector<Ring>& rings = combined.rings.rings;
    for (std::size_t r = rings.size(); r-- > 0;) {
        const bool is_small = std::abs(signed_area(rings[r].at)) < disc_area;
        if (!is_largest[r] && is_small && !has_ring_in_it(rings, r)) drop(rings, r, dropped);
    }
}

// Drops the triangles that are left where hardly anything of a ring is: their vertices cannot keep apart.
void drop_crumbs(const StructureRings& before, double least_mm, std::vector<Ring>& rings,
                 std::uint32_t& dropped) {
    for (std::size_t r = rings.size(); r-- > 0;) {
        const std::vector<Vec2>& at = rings[r].at;
        if (at.size() > 3) continue;
        const double shortest =
            std::min({length(at[1] - at[0]), length(at[2] - at[1]), length(at[0] - at[2])});
        const bool was_there = std::any_of(before.rings.begin(), before.rings.end(),
                                           [&](const Ring& ring) { return ring.points == rings[r].points; });
        if (shortest < least_mm && !was_there && !has_ring_in_it(rings, r)) drop(rings, r, dropped);
    }
}

}  // namespace

Result<DrawResult> nudge_outline(const StructureRings& before, std::span<const Vec2> path,
                                 const NudgeOptions& options) {
    const StandardArithmetic arithmetic;
    ANATOMESH_CHECK_STATUS(check_option(options.pixel_mm, least_pixel_mm, most_pixel_mm, "pixel_mm"));
    if (path.empty()) return nothing_drawn(before, NothingDrawn::too_short);
    ANATOMESH_TRY(std::vector<Ring> sweep, swept_disc(path, before.plane, options.disc));
    ANATOMESH_TRY(const ClippedArea clipped, clip_area(std::move(sweep), options.clip, before.plane));
    // A structure that is not there cannot be pushed, and one that is begins outside of nothing.
    const AreaRule rule = lies_in(before, path[0]) ? AreaRule::unite : AreaRule::subtract;
    ANATOMESH_TRY(CombinedArea combined, combine_area(before, clipped.rings, rule));
    DrawResult drawing = nothing_drawn(before, NothingDrawn::nothing_there);
    drawing.is_clipped = clipped.is_cut;
    if (combined.effect == AreaEffect::nothing) return drawing;
    const double radius = options.disc.radius_mm;
    drop_small_pieces(combined, before.rings.size(), std::numbers::pi * radius * radius,
                      drawing.dropped_pieces);
    drawing.rings = std::move(combined.rings);
    const double least = least_spacing_pixels * options.pixel_mm;
    space_new_vertices(before, least, drawing.rings);
    drop_crumbs(before, least, drawing.rings.rings, drawing.dropped_pieces);
    if (are_same(before.rings, drawing.rings.rings)) return drawing;
    drawing.effect = combined.effect;
    drawing.reason = NothingDrawn::none;
    drawing.sliver_area_mm2 = combined.sliver_area_mm2;
    return drawing;
}

}  // namespace anatomesh
