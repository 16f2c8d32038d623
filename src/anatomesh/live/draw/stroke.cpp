#include "anatomesh/live/draw/stroke.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <optional>
#include <utility>

#include "anatomesh/base/standard_arithmetic.h"
#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/live/draw/area/line_crossing.h"
#include "anatomesh/live/draw/area/thin_line.h"
#include "anatomesh/live/draw/area/tool_ranges.h"
#include "anatomesh/live/draw/reshape.h"

namespace anatomesh {

namespace {

// A stroke that stays this near to its first point is a click: a jitter of two pixels in both directions is 2.83.
// [pixels; > 0; C]
constexpr double click_pixels = 3;
// Both tails of a stroke together are at most this share of its length. A star of five strokes would lose 19 %.
// [1, of the length; 0 to 0.19; D a choice, measurement not recorded]
constexpr double tail_share = 0.15;

bool is_click(std::span<const Vec2> stroke, double pixel_mm) {
    return std::all_of(stroke.begin(), stroke.end(),
                       [&](Vec2 p) { return length(p - stroke[0]) < click_pixels * pixel_mm; });
}

// Where the end of a line first meets its beginning, by the edges that meet.
struct TailMeeting {
    std::size_t head = 0, tail = 0;
    Vec2 at;
};

// `along`: per point, the length of the line up to it. The tails together are at most `most` long.
std::optional<TailMeeting> first_meeting(std::span<const Vec2> line, const std::vector<double>& along,
                                         double most) {
    const double whole = along.back();
    std::vector<Segment2> segments;
    std::vector<std::size_t> edge_of;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        if ((along[i] > most && along[i + 1] < whole - most) || line[i] == line[i + 1]) continue;
        segments.push_back({line[i], line[i + 1]});
        edge_of.push_back(i);
    }
    std::optional<TailMeeting> found;
    double first = whole;  // how far the meeting is along the line
    const SegmentIndex index(std::move(segments));
    index.for_each_near_pair([&](std::uint32_t s, std::uint32_t t) {
        const std::size_t i = edge_of[s], j = edge_of[t];
        if (j == i + 1) return true;
        const Segment2 &head = index.segments()[s], &tail = index.segments()[t];
        if (segment_contact(head.a, head.b, tail.a, tail.b) == SegmentContact::none) return true;
        const Vec2 at = line_crossing(tail.a, tail.b, head.a, head.b);
        const double there = along[j] + length(at - tail.a),
                     tails = along[i] + length(at - head.a) + whole - there;
        if (tails <= most && there < first) first = there, found = TailMeeting{i, j, at};
        return true;
    });
    return found;
}

}  // namespace

std::vector<Vec2> without_tails(std::span<const Vec2> line) {
    if (line.size() < 4 || line.front() == line.back()) return {line.begin(), line.end()};
    std::vector<double> along{0};
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
        along.push_back(along.back() + length(line[i + 1] - line[i]));
    const double most = tail_share * along.back();
    if (const std::optional<TailMeeting> meeting = first_meeting(line, along, most)) {
        std::vector<Vec2> closed{meeting->at};
        for (std::size_t i = meeting->head + 1; i <= meeting->tail; ++i) closed.push_back(line[i]);
        return closed;
    }
    std::size_t nearest = line.size() - 1;
    for (std::size_t i = nearest; i > 0 && along[i] >= along.back() - most; --i) {
        if (length(line[i] - line[0]) < length(line[nearest] - line[0])) nearest = i;
    }
    return {line.begin(), line.begin() + static_cast<std::ptrdiff_t>(nearest) + 1};
}

Result<DrawResult> draw_stroke(const StructureRings& before, std::span<const Vec2> stroke,
                               const StrokeOptions& options) {
    const StandardArithmetic arithmetic;
    ANATOMESH_CHECK_STATUS(check_points(stroke, "the stroke"));
    ANATOMESH_CHECK_STATUS(
        check_option(options.tolerance_mm, least_tolerance_mm, most_tolerance_mm, "tolerance_mm"));
    ANATOMESH_CHECK_STATUS(check_option(options.pixel_mm, least_pixel_mm, most_pixel_mm, "pixel_mm"));
    ANATOMESH_CHECK_STATUS(check_option(options.reach_mm, 0, most_reach_mm, "reach_mm"));
    if (is_click(stroke, options.pixel_mm)) return nothing_drawn(before, NothingDrawn::too_short);
    if (options.mode == DrawMode::reshape) {
        return reshape_outline(before, thin_line(stroke, options.tolerance_mm), options.reach_mm,
                               options.clip);
    }
    const std::vector<Vec2> polygon = thin_line(without_tails(stroke), options.tolerance_mm);
    return draw_polygon(before, polygon, options.mode, options.clip);
}

Result<DrawResult> draw_polygon(const StructureRings& before, std::span<const Vec2> corners, DrawMode mode,
                                std::span<const Vec2> clip) {
    const StandardArithmetic arithmetic;
    assert(mode != DrawMode::reshape);
    ANATOMESH_CHECK_STATUS(check_points(corners, "the polygon"));
    const Ring ring = ring_of(corners, before.plane);
    if (ring.size() < 3) return nothing_drawn(before, NothingDrawn::no_area);
    return draw_area(before, {ring}, corners[0], mode, clip);
}

}  // namespace anatomesh
