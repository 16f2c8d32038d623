#include "anatomesh/live/draw/area/clip_area.h"

#include <cstddef>
#include <utility>

#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/live/draw/area/ring_overlay.h"

namespace anatomesh {

namespace {

// What is outside by no more is inside but for rounding. [mm; 0 to 0.01; D digits of files]
constexpr double clip_rounding_mm = 1e-6;

// 1 for a convex polygon that runs counter-clockwise once around, -1 for clockwise, 0 for any other.
int convex_turn(const std::vector<Vec2>& polygon) {
    int turn = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        // A convex polygon has all its points on one side of each edge.
        const Vec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        for (const Vec2 p : polygon) {
            const int side = orient2d(a, b, p);
            if (side != 0 && side == -turn) return 0;
            if (side != 0) turn = side;
        }
    }
    return turn;
}

bool is_within(const Ring& clip, int turn, Vec2 p) {
    for (std::size_t i = 0; i < clip.size(); ++i) {
        const Vec2 a = clip.at[i], along = clip.at[(i + 1) % clip.size()] - a;
        if (turn * cross(along, p - a) < -clip_rounding_mm * length(along)) return false;
    }
    return true;
}

}  // namespace

Result<ClippedArea> clip_area(std::vector<Ring> area, std::span<const Vec2> clip, const Plane& plane) {
    if (clip.empty()) return ClippedArea{std::move(area), false};
    ANATOMESH_CHECK_STATUS(check_points(clip, "the clip"));
    const Ring border = ring_of(clip, plane);
    const int turn = convex_turn(border.at);
    if (border.size() < 3 || turn == 0) {
        return Error{ErrorKind::usage,
                     "E-LIV-009",
                     "the polygon that drawn areas are clipped to is not convex",
                     {},
                     "give the corners of the image in their order"};
    }
    bool is_cut = false;
    for (const Ring& ring : area) {
        for (const Vec2 p : ring.at) is_cut = is_cut || !is_within(border, turn, p);
    }
    if (!is_cut) return ClippedArea{std::move(area), false};

    const std::vector<Ring> borders{border};
    const std::optional<RingOverlay> overlay = RingOverlay::make(area, borders, plane);
    if (!overlay) return crosses_too_often();
    std::vector<char> inside;
    for (const FaceSides& face : overlay->faces()) inside.push_back(face.in_structure && face.in_area);
    ClippedArea clipped{{}, true};
    for (RegionRing& ring : overlay->region(inside).rings) clipped.rings.push_back(std::move(ring.ring));
    return clipped;
}

}  // namespace anatomesh
