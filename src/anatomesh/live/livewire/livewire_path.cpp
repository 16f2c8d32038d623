#include "anatomesh/live/livewire/livewire_path.h"

#include <cassert>
#include <utility>

#include "anatomesh/base/plural.h"

namespace anatomesh {

namespace {

void append_distinct(const std::vector<Vec2>& line, std::vector<Vec2>& points) {
    for (const Vec2 p : line) {
        if (points.empty() || !(points.back() == p)) points.push_back(p);
    }
}

}  // namespace

LivewirePath::LivewirePath(const LivewireCosts& costs, const LivewireOptions& options)
    : options_(options), wire_(costs, options) {}

Result<NearestPixel> LivewirePath::add_anchor(Vec2 point, LivewireSegment segment) {
    ANATOMESH_CHECK_STATUS(check_picture_point(point, "anchor"));
    std::vector<Vec2> line;
    if (!anchors_.empty()) {
        ANATOMESH_TRY(LivewireLine frozen, line_to(point, segment));
        line = std::move(frozen.points);
    }
    ANATOMESH_TRY(const NearestPixel nearest, wire_.set_anchor(point));
    anchors_.push_back(wire_.grid().position(nearest.pixel));
    if (line.empty()) line.push_back(anchors_.back());
    lines_.push_back(std::move(line));
    return nearest;
}

bool LivewirePath::step_back() {
    if (anchors_.empty()) return false;
    anchors_.pop_back();
    lines_.pop_back();
    if (!anchors_.empty()) {
        [[maybe_unused]] const auto moved = wire_.set_anchor(anchors_.back());
        assert(moved.ok());
    }
    return true;
}

Result<LivewireLine> LivewirePath::line_to(Vec2 pointer, LivewireSegment segment) {
    assert(!anchors_.empty());
    if (segment == LivewireSegment::along_edges) return wire_.line_to(pointer);
    ANATOMESH_CHECK_STATUS(check_picture_point(pointer, "pointer"));
    const NearestPixel nearest = wire_.grid().nearest(pointer);
    LivewireLine line;
    line.cheapest = false;
    line.inside = nearest.inside;
    append_distinct({anchors_.back(), wire_.grid().position(nearest.pixel)}, line.points);
    return line;
}

Result<std::vector<Vec2>> LivewirePath::ring(LivewireSegment segment) {
    std::vector<Vec2> points = frozen();
    if (anchors_.size() > 1) {
        ANATOMESH_TRY(const LivewireLine last, line_to(anchors_.front(), segment));
        append_distinct(last.points, points);
        if (points.size() > 1 && points.back() == points.front()) points.pop_back();
    }
    if (points.size() < 3) {
        return Error{ErrorKind::input,
                     "E-LIV-107",
                     "a ring cannot have " + counted(points.size(), "point"),
                     {},
                     "add anchors until the line surrounds an area"};
    }
    return points;
}

std::vector<Vec2> LivewirePath::frozen() const {
    std::vector<Vec2> points;
    for (const std::vector<Vec2>& line : lines_) append_distinct(line, points);
    return points;
}

void LivewirePath::set_costs(const LivewireCosts& costs) {
    assert(costs.grid == wire_.grid());
    wire_ = Livewire(costs, options_);
    if (!anchors_.empty()) {
        [[maybe_unused]] const auto moved = wire_.set_anchor(anchors_.back());
        assert(moved.ok());
    }
}

}  // namespace anatomesh
