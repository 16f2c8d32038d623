#include "anatomesh/live/draw/reshape.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "anatomesh/contour/overlay/even_odd_area.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/live/draw/area/clip_area.h"
#include "anatomesh/live/draw/area/line_crossing.h"
#include "anatomesh/live/draw/area/ring_overlay.h"

namespace anatomesh {

namespace {

// A line that is joined to a ring this near to a vertex is joined to the vertex. [mm; 0 to 0.1; D]
constexpr double joined_vertex_mm = 0.01;

// Where a line is joined to a ring: a point on the ring's edge from vertex `edge` on.
struct Joint {
    std::size_t edge = 0;
    Vec2 at;
    double share = 0;       // of the edge, up to the point
    std::size_t first = 0;  // the line's first point after the joint
    double along = 0;       // how far the joint is along the line
};

Vec2 next_of(const Ring& ring, std::size_t i) {
    return ring.at[i + 1 < ring.size() ? i + 1 : 0];
}

Joint joint_on(const Ring& ring, std::size_t edge, Vec2 at) {
    const Vec2 a = ring.at[edge], b = next_of(ring, edge);
    if (length(at - a) <= joined_vertex_mm) return {edge, a, 0};
    if (length(at - b) <= joined_vertex_mm) return {(edge + 1) % ring.size(), b, 0};
    return {edge, at, length(at - a) / length(b - a)};
}

// Where the line from p to q first meets the ring.
std::optional<Joint> first_crossing(const Ring& ring, Vec2 p, Vec2 q) {
    std::optional<std::pair<std::size_t, Vec2>> found;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        if (segment_contact(p, q, ring.at[i], next_of(ring, i)) == SegmentContact::none) continue;
        const Vec2 at = line_crossing(p, q, ring.at[i], next_of(ring, i));
        if (!found || length(at - p) < length(found->second - p)) found = std::pair(i, at);
    }
    if (!found) return std::nullopt;
    return joint_on(ring, found->first, found->second);
}

struct Foot {
    std::size_t edge = 0;
    double distance = 0;
};

Foot foot_on(const Ring& ring, Vec2 p) {
    Foot foot{0, distance_to_segment(p, ring.at[0], next_of(ring, 0))};
    for (std::size_t i = 1; i < ring.size(); ++i) {
        const double distance = distance_to_segment(p, ring.at[i], next_of(ring, i));
        if (distance < foot.distance) foot = {i, distance};
    }
    return foot;
}

// Where a line is joined to the ring at its beginning.
std::optional<Joint> joint_at_beginning(const Ring& ring, std::span<const Vec2> line, double reach_mm) {
    std::optional<Joint> crossing;
    double along = 0;
    for (std::size_t k = 0; k + 1 < line.size() && !crossing; ++k) {
        crossing = first_crossing(ring, line[k], line[k + 1]);
        if (crossing) {
            crossing->first = k + 1;
            crossing->along = along + length(crossing->at - line[k]);
        }
        along += length(line[k + 1] - line[k]);
    }
    if (crossing && crossing->along <= reach_mm) return crossing;
    const Foot foot = foot_on(ring, line[0]);
    if (foot.distance > reach_mm) return crossing;
    const Vec2 a = ring.at[foot.edge], b = next_of(ring, foot.edge);
    const double share = std::clamp(dot(line[0] - a, b - a) / squared_length(b - a), 0.0, 1.0);
    return joint_on(ring, foot.edge, a + share * (b - a));
}

std::size_t nearest_ring(const StructureRings& before, Vec2 p) {
    std::size_t nearest = 0;
    double least = foot_on(before.rings[0], p).distance;
    for (std::size_t r = 1; r < before.rings.size(); ++r) {
        const double distance = foot_on(before.rings[r], p).distance;
        if (distance < least) least = distance, nearest = r;
    }
    return nearest;
}

double length_of(std::span<const Vec2> line) {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) sum += length(line[i + 1] - line[i]);
    return sum;
}

void append(Ring& to, const Ring& from, std::size_t i) {
    if (to.at.empty() || to.at.back() != from.at[i]) to.push_back(from.at[i], from.points[i]);
}

// The line from joint to joint, and back along the ring: forwards, or backwards.
Ring closed_along(const Ring& ring, const Ring& line, const Joint& begin, const Joint& end, bool forwards) {
    Ring closed = line;
    const std::size_t n = ring.size();
    std::size_t between = (end.edge + n - begin.edge) % n;  // vertices from `begin` forwards to `end`
    if (begin.edge == end.edge && begin.share > end.share) between = n;
    if (forwards) {
        for (std::size_t k = 1; k <= n - between; ++k) append(closed, ring, (end.edge + k) % n);
    } else {
        for (std::size_t k = 0; k < between; ++k) append(closed, ring, (end.edge + n - k) % n);
    }
    while (closed.size() > 1 && closed.at.back() == closed.at.front())
        closed.at.pop_back(), closed.points.pop_back();
    return closed;
}

double area_of_polygon(const Ring& ring) {
    std::vector<Segment2> segments;
    Box2 box;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        segments.push_back({ring.at[i], next_of(ring, i)});
        box.extend(ring.at[i]);
    }
    return even_odd_area(std::move(segments), box);
}

std::uint32_t depth_of(const std::vector<std::int32_t>& parents, std::size_t ring) {
    std::uint32_t depth = 0;
    for (std::int32_t r = parents[ring]; r >= 0; r = parents[static_cast<std::size_t>(r)]) ++depth;
    return depth;
}

// The ring with the line in the place of the stretch that changes least.
std::optional<Ring> reshaped_ring(const Ring& ring, std::span<const Vec2> line, double reach_mm,
                                  const Plane& plane) {
    const std::optional<Joint> begin = joint_at_beginning(ring, line, reach_mm);
    const std::vector<Vec2> reversed(line.rbegin(), line.rend());
    const std::optional<Joint> end = joint_at_beginning(ring, reversed, reach_mm);
    if (!begin || !end || begin->along + end->along >= length_of(line) || begin->at == end->at)
        return std::nullopt;
    std::vector<Vec2> between{begin->at};
    for (std::size_t i = begin->first; i + end->first < line.size(); ++i) between.push_back(line[i]);
    between.push_back(end->at);
    Ring drawn = ring_of(between, plane);
    if (drawn.size() < 2) return std::nullopt;
    // A joint at a vertex is the vertex, in space too.
    if (begin->share == 0)
        drawn.at.front() = ring.at[begin->edge], drawn.points.front() = ring.points[begin->edge];
    if (end->share == 0) drawn.at.back() = ring.at[end->edge], drawn.points.back() = ring.points[end->edge];
    Ring forwards = closed_along(ring, drawn, *begin, *end, true);
    Ring backwards = closed_along(ring, drawn, *begin, *end, false);
    return area_of_polygon(forwards) >= area_of_polygon(backwards) ? std::move(forwards)
                                                                   : std::move(backwards);
}

}  // namespace

Result<DrawResult> reshape_outline(const StructureRings& before, std::span<const Vec2> line, double reach_mm,
                                   std::span<const Vec2> clip) {
    if (before.rings.empty() || line.size() < 2) return nothing_drawn(before, NothingDrawn::no_outline);
    const std::size_t r = nearest_ring(before, line[0]);
    const std::optional<Ring> ring = reshaped_ring(before.rings[r], line, reach_mm, before.plane);
    if (!ring) return nothing_drawn(before, NothingDrawn::no_outline);
    ANATOMESH_TRY(const ClippedArea clipped, clip_area({*ring}, clip, before.plane));
    std::vector<Ring> area{*ring};
    if (clipped.is_cut) area.push_back(ring_of(clip, before.plane));

    const std::optional<RingOverlay> overlay = RingOverlay::make(before.rings, area, before.plane);
    if (!overlay) return crosses_too_often();
    const auto drawn = static_cast<std::uint32_t>(before.rings.size());
    const bool is_hole = depth_of(overlay->parents(), r) % 2 == 1;
    std::vector<char> inside;
    for (std::uint32_t face = 0; face < overlay->faces().size(); ++face) {
        const bool was = overlay->is_in(face, static_cast<std::uint32_t>(r)),
                   is = overlay->is_in(face, drawn);
        const bool may_grow = !clipped.is_cut || overlay->is_in(face, drawn + 1);
        const bool joins = is_hole ? was && !is : is && !was && may_grow;
        const bool leaves = is_hole ? is && !was : was && !is;
        inside.push_back(joins || (overlay->faces()[face].in_structure && !leaves));
    }
    Region region = overlay->region(inside);
    DrawResult drawing = nothing_drawn(before, NothingDrawn::none);
    drawing.is_clipped = clipped.is_cut;
    drawing.sliver_area_mm2 = region.sliver_area_mm2;
    drawing.rings.rings.clear();
    bool is_unchanged = region.rings.size() == before.rings.size();
    for (RegionRing& found : region.rings) {
        is_unchanged = is_unchanged && found.is_unchanged;
        drawing.rings.rings.push_back(std::move(found.ring));
    }
    if (is_unchanged) {
        drawing.reason = NothingDrawn::nothing_there;
    } else {
        drawing.effect = AreaEffect::reshaped;
    }
    return drawing;
}

}  // namespace anatomesh
