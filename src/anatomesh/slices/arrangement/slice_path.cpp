#include "anatomesh/slices/arrangement/slice_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/slices/arrangement/mirrored_frame.h"

namespace anatomesh {

namespace {

// Planes at a smaller angle are joined straight: over a metre the two ways differ by less than a thousandth of a
// millimetre. [radians; 0 to 0.01; D]
constexpr double least_turn = 1e-6;
// A plane within 30 degrees of a path's slices, of which this is the cosine, was one of them.
// [1, cosine; 0 to 1; C]
constexpr double across_path = 0.866;

Vec3 middle_of(const Plane& plane, const Box2& box) {
    return plane.to_space(0.5 * (box.low + box.high));
}

std::array<Vec2, 4> corners_of(const Box2& box) {
    return {box.low, Vec2{box.high.x, box.low.y}, box.high, Vec2{box.low.x, box.high.y}};
}

// So that `other` lies before the plane.
Plane turned_towards(Plane plane, Vec3 other) {
    if (plane.signed_distance(other) > 0) return plane;
    plane.normal = -1.0 * plane.normal;
    plane.v = -1.0 * plane.v;
    return plane;
}

}  // namespace

PlanePatch patch_of(const ContourSet& set, const PathSlice& part) {
    const Plane& plane = set.slices[part.slice].plane;
    PlanePatch patch{plane, {}, HUGE_VAL, -HUGE_VAL};
    for (const std::uint32_t c : part.contours) {
        for (const Vec3& point : set.points_of(set.contours[c])) {
            const double height = plane.signed_distance(point);
            patch.low = std::min(patch.low, height);
            patch.high = std::max(patch.high, height);
            patch.box.extend(plane.to_plane(point));
        }
    }
    return patch;
}

SlicePath::SlicePath(const ContourSet& set, std::vector<PathSlice> slices) : slices_(std::move(slices)) {
    const std::size_t count = slices_.size();
    std::vector<PlanePatch> patches;
    for (const PathSlice& part : slices_) patches.push_back(patch_of(set, part));
    const auto middle = [&](std::size_t n) { return middle_of(patches[n].plane, patches[n].box); };
    double height = 0;
    for (std::size_t n = 0; n < count; ++n) {
        // Along the path: the next slice lies before it, of the last one the one before it behind.
        const Vec3 here = middle(n), next = n + 1 < count ? middle(n + 1) : here + (here - middle(n - 1));
        Plane plane = turned_towards(patches[n].plane, next);
        if (n > 0)
            plane = mirrored_frame(layers_.back().plane, plane);
        else
            plane.origin = middle(0);
        // As to_chart() finds them, to the last bit.
        Layer layer{plane, HUGE_VAL, -HUGE_VAL, {}, 0};
        for (const std::uint32_t c : slices_[n].contours) {
            for (const Vec3& point : set.points_of(set.contours[c])) {
                const double off = plane.signed_distance(point);
                layer.low = std::min(layer.low, off);
                layer.high = std::max(layer.high, off);
                layer.box.extend(plane.to_plane(point));
            }
        }
        if (n > 0) {
            turns_.push_back(turn_between(layers_.back(), layer));
            height += length_of(layers_.back(), layer, turns_.back());
        }
        layer.height = height;
        layers_.push_back(layer);
    }
}

SlicePath::Turn SlicePath::turn_between(const Layer& below, const Layer& above) {
    Turn turn;
    const Plane &a = below.plane, &b = above.plane;
    // Above the lower plane's point q the upper plane is -(at + q . slope) away.
    const Vec2 slope{dot(a.u, b.normal), dot(a.v, b.normal)};
    const double sine = length(slope), angle = std::atan2(sine, dot(a.normal, b.normal));
    if (angle < least_turn) return turn;
    turn.angle = angle;
    turn.away = (-1 / sine) * slope;
    turn.line_at = b.signed_distance(a.origin) / sine;
    return turn;
}

// As far as the path is between the middles of two slices.
double SlicePath::length_of(const Layer& below, const Layer& above, const Turn& turn) {
    const Vec2 lower = 0.5 * (below.box.low + below.box.high), upper = 0.5 * (above.box.low + above.box.high);
    if (turn.angle == 0)
        return below.plane.signed_distance(above.plane.to_space(upper)) - below.high + above.low;
    return turn.angle * (0.5 * dot(lower + upper, turn.away) - turn.line_at);
}

std::optional<Vec3> SlicePath::between(std::size_t gap, Vec3 p) const {
    const Layer &below = layers_[gap - 1], &above = layers_[gap];
    const double over = below.plane.signed_distance(p), under = above.plane.signed_distance(p);
    if (over < below.low || under > above.high) return std::nullopt;
    if (over <= below.high) {
        const Vec2 q = below.plane.to_plane(p);
        return Vec3{q.x, q.y, below.height};
    }
    if (under >= above.low) {
        const Vec2 q = above.plane.to_plane(p);
        return Vec3{q.x, q.y, above.height};
    }
    const Turn& turn = turns_[gap - 1];
    const double from = over - below.high, to = above.low - under;
    const Vec2 foot = below.plane.to_plane(p);
    if (turn.angle == 0) {
        const double t = from / (from + to);
        const Vec2 q = foot + t * (above.plane.to_plane(p) - foot);
        return Vec3{q.x, q.y, below.height + t * (above.height - below.height)};
    }
    const double x = dot(foot, turn.away) - turn.line_at, radius = std::hypot(x, from);
    // What is left of the radius, without the loss of digits far from the line.
    const double outwards = x > 0 ? from * from / (radius + x) : radius - x;
    const double t = std::clamp(std::atan2(from, x) / turn.angle, 0.0, 1.0);
    const Vec2 q = foot + outwards * turn.away;
    return Vec3{q.x, q.y, below.height + t * (above.height - below.height)};
}

std::optional<Vec3> SlicePath::to_chart(std::size_t gap, Vec3 p) const {
    if (gap > 0 && gap < layers_.size()) return between(gap, p);
    const Layer& end = gap == 0 ? layers_.front() : layers_.back();
    const double height = end.plane.signed_distance(p);
    const double beyond = gap == 0 ? std::min(height - end.low, 0.0) : std::max(height - end.high, 0.0);
    if (gap == 0 ? height > end.high : height < end.low) return std::nullopt;
    const Vec2 q = end.plane.to_plane(p);
    return Vec3{q.x, q.y, end.height + beyond};
}

Box3 SlicePath::box_of(std::size_t gap, double reach) const {
    const std::size_t first = gap == 0 ? 0 : gap - 1, last = std::min(gap, layers_.size() - 1);
    Box2 box = layers_[first].box;
    box.extend(layers_[last].box.low);
    box.extend(layers_[last].box.high);
    box = box.grown(reach);
    Box3 result;
    double bulge = 0;
    for (const Vec2 corner : corners_of(box)) {
        for (const std::size_t n : {first, last}) {
            const Plane& plane = layers_[n].plane;
            result.extend(plane.to_space(corner));
            if (gap == 0) result.extend(plane.to_space(corner) - reach * plane.normal);
            if (gap == layers_.size()) result.extend(plane.to_space(corner) + reach * plane.normal);
        }
        if (first == last) continue;
        // A turning corner leaves its chord by this at most.
        const Turn& turn = turns_[first];
        const double radius = std::abs(dot(corner, turn.away) - turn.line_at);
        bulge = std::max(bulge, turn.angle == 0 ? 0.0 : radius * (1 - std::cos(0.5 * turn.angle)));
    }
    const double thick =
        std::max(layers_[first].high - layers_[first].low, layers_[last].high - layers_[last].low);
    return result.grown(bulge + thick);
}

ContourSet SlicePath::to_chart(const ContourSet& set) const {
    ContourSet charted = chosen_slices(set, {});
    for (std::uint32_t n = 0; n < layers_.size(); ++n) {
        const Layer& layer = layers_[n];
        Slice slice = set.slices[slices_[n].slice];
        slice.plane = {{0, 0, layer.height}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        slice.first_contour = static_cast<std::uint32_t>(charted.contours.size());
        slice.contour_count = static_cast<std::uint32_t>(slices_[n].contours.size());
        charted.slices.push_back(std::move(slice));
        for (const std::uint32_t c : slices_[n].contours) {
            Contour contour = set.contours[c];
            for (const Vec3& point : set.points_of(set.contours[c])) {
                const Vec2 q = layer.plane.to_plane(point);
                charted.points.push_back({q.x, q.y, layer.height});
            }
            contour.slice = n;
            contour.first_point = static_cast<std::uint32_t>(charted.points.size()) - contour.point_count;
            // Outer contours stay counter-clockwise where the path runs against the slice's normal.
            if (dot(layer.plane.normal, set.slices[slices_[n].slice].plane.normal) < 0)
                std::reverse(charted.points.begin() + contour.first_point + 1, charted.points.end());
            charted.contours.push_back(contour);
        }
    }
    // A slice that was left out parts the gap in which it crosses the path at about a right angle.
    charted.left_out.clear();
    for (LeftOutSlice slice : set.left_out) {
        for (std::size_t n = 0; n + 1 < layers_.size(); ++n) {
            const Plane &a = layers_[n].plane, &b = layers_[n + 1].plane;
            const double from = slice.plane.signed_distance(middle_of(a, layers_[n].box)),
                         to = slice.plane.signed_distance(middle_of(b, layers_[n + 1].box));
            if ((from < 0) == (to < 0) ||
                std::abs(dot(slice.plane.normal, normalized(a.normal + b.normal))) < across_path)
                continue;
            const double t = from / (from - to);
            slice.plane = {{0, 0, layers_[n].height + t * (layers_[n + 1].height - layers_[n].height)},
                           {1, 0, 0},
                           {0, 1, 0},
                           {0, 0, 1}};
            charted.left_out.push_back(slice);
            break;
        }
    }
    return charted;
}

Plane SlicePath::slice_at(double height) const {
    return std::min_element(layers_.begin(), layers_.end(),
                            [&](const Layer& a, const Layer& b) {
                                return std::abs(a.height - height) < std::abs(b.height - height);
                            })
        ->plane;
}

}  // namespace anatomesh
