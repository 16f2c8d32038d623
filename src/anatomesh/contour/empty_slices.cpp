#include "anatomesh/contour/empty_slices.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/contour/message_text.h"
#include "anatomesh/contour/plane_grouping.h"

namespace anatomesh {

namespace {

constexpr double least_gap = 0.1;  // of the median spacing

// On the common normal of the set, seen from its middle: a plane's own origin may lie far away on it.
struct Placed {
    double position = 0;
    const EmptyPlane* plane = nullptr;
};

// The planes that are parallel to the slices, rising; the names of the others go to `crossing`.
std::vector<Placed> place(const ContourSet& set, std::span<const EmptyPlane> planes, double tolerance_mm,
                          std::vector<std::string>& crossing) {
    const Vec3 normal = set.slices.front().plane.normal, middle = 0.5 * (set.box().low + set.box().high);
    const double reach = set.box().diagonal() / 2;
    std::vector<Placed> placed;
    for (const EmptyPlane& one : planes) {
        const Plane& plane = one.plane;
        if (length(cross(normal, plane.normal)) * reach > tolerance_mm) {
            crossing.push_back(one.name);
            continue;
        }
        const Vec3 foot = middle - plane.signed_distance(middle) * plane.normal;
        placed.push_back({dot(normal, foot), &one});
    }
    std::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
        return a.position != b.position ? a.position < b.position : a.plane->name < b.plane->name;
    });
    return placed;
}

// One that stands at `position` along the normal of the slices.
Plane plane_at(const Plane& slice, double position) {
    Plane plane = slice;
    plane.origin = position * slice.normal;
    const int axis = axis_of(slice);
    if (axis >= 0)
        plane.origin = {axis == 0 ? position : 0, axis == 1 ? position : 0, axis == 2 ? position : 0};
    return plane;
}

void insert(ContourSet& set, std::vector<Slice> more) {
    const Vec3 normal = set.slices.front().plane.normal;
    std::vector<Slice> all = std::move(set.slices);
    all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
    std::stable_sort(all.begin(), all.end(), [&](const Slice& a, const Slice& b) {
        return dot(a.plane.origin, normal) < dot(b.plane.origin, normal);
    });
    std::uint32_t next = 0;
    for (std::uint32_t s = 0; s < all.size(); ++s) {
        all[s].first_contour = next;
        for (std::uint32_t c = 0; c < all[s].contour_count; ++c) set.contours[next + c].slice = s;
        next += all[s].contour_count;
    }
    set.slices = std::move(all);
}

}  // namespace

std::string slice_text(const Plane& plane, const std::string& given, std::size_t number) {
    if (!given.empty()) return given;
    const int axis = axis_of(plane);
    if (axis < 0) return "plane " + std::to_string(number);
    const double position = axis == 0 ? plane.origin.x : axis == 1 ? plane.origin.y : plane.origin.z;
    return std::string(1, "xyz"[axis]) + " = " + full(position);
}

EmptySlices keep_empty_slices(ContourSet& set, std::span<const EmptyPlane> planes,
                              double parallel_tolerance_mm) {
    EmptySlices result;
    if (planes.empty() || set.slices.empty()) return result;
    if (!all_parallel(set, parallel_tolerance_mm)) {
        for (const EmptyPlane& plane : planes) result.not_placed.push_back(plane.name);
        return result;
    }
    const std::vector<Placed> placed = place(set, planes, parallel_tolerance_mm, result.not_placed);
    const Vec3 normal = set.slices.front().plane.normal;
    const double nearest = least_gap * median_spacing(set);
    std::vector<Slice> more;
    std::size_t next = 0;  // the first slice with contours that is not before the plane
    for (const Placed& one : placed) {
        const auto position = [&](std::size_t s) { return dot(set.slices[s].plane.origin, normal); };
        while (next < set.slices.size() && position(next) < one.position) ++next;
        if (next == 0 || next == set.slices.size()) continue;
        double before = one.position - position(next - 1);
        if (!more.empty()) before = std::min(before, one.position - dot(more.back().plane.origin, normal));
        if (std::min(before, position(next) - one.position) <= nearest) continue;
        result.kept.push_back(one.plane->name);
        more.push_back({plane_at(set.slices.front().plane, one.position), 0, 0, one.plane->name});
    }
    insert(set, std::move(more));
    return result;
}

}  // namespace anatomesh
