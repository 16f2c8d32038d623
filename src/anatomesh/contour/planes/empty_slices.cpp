#include "anatomesh/contour/planes/empty_slices.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/planes/plane_grouping.h"

namespace anatomesh {

namespace {

// A plane nearer to what is drawn on one side, as a share of the way to the other, is one slice with it.
// [1; 0 to 0.5; D a choice, measurement not recorded]
constexpr double least_gap = 0.05;

// Where a plane lies among what is drawn.
struct Place {
    bool crosses = false;  // what is drawn on one slice
    // Of what is drawn on either side the nearest to it; infinite: nothing.
    double below = std::numeric_limits<double>::infinity(), above = below;

    bool is_between() const { return !crosses && std::isfinite(below) && std::isfinite(above); }
    double least_distance() const { return least_gap * (below + above); }
};

Place place_of(const ContourSet& set, const Plane& plane) {
    Place place;
    for (const Slice& slice : set.slices) {
        if (slice.contour_count == 0) continue;
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const Contour& contour : set.contours_of(slice)) {
            for (const Vec3& p : set.points_of(contour)) {
                const double height = plane.signed_distance(p);
                low = std::min(low, height);
                high = std::max(high, height);
            }
        }
        if (low > 0) {
            place.above = std::min(place.above, low);
        } else if (high < 0) {
            place.below = std::min(place.below, -high);
        } else {
            place.crosses = true;
            return place;
        }
    }
    return place;
}

// Whether the plane is one with another one that is kept, as seen from the middle of the set.
bool is_given_again(const Plane& plane, const std::vector<Slice>& kept, Vec3 middle, double distance) {
    const Vec3 foot = middle - plane.signed_distance(middle) * plane.normal;
    return std::any_of(kept.begin(), kept.end(), [&](const Slice& slice) {
        return std::abs(slice.plane.signed_distance(foot)) <= distance;
    });
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

void sort_by_position(ContourSet& set) {
    const Vec3 normal = set.slices.front().plane.normal;
    std::stable_sort(set.slices.begin(), set.slices.end(), [&](const Slice& a, const Slice& b) {
        return dot(a.plane.origin, normal) < dot(b.plane.origin, normal);
    });
    std::uint32_t next = 0;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        Slice& slice = set.slices[s];
        slice.first_contour = next;
        for (std::uint32_t c = 0; c < slice.contour_count; ++c) set.contours[next + c].slice = s;
        next += slice.contour_count;
    }
}

}  // namespace

std::string slice_text(const Plane& plane, const std::string& given, std::size_t number) {
    if (!given.empty()) return given;
    const int axis = axis_of(plane);
    if (axis < 0) return "plane " + std::to_string(number);
    const double position = axis == 0 ? plane.origin.x : axis == 1 ? plane.origin.y : plane.origin.z;
    return std::string(1, "xyz"[axis]) + " = " + pointed_text(position);
}

std::vector<std::string> keep_empty_slices(ContourSet& set, std::span<const EmptyPlane> planes,
                                           double tolerance_mm) {
    std::vector<std::string> not_placed;
    if (planes.empty() || set.slices.empty()) return not_placed;
    const bool parallel = all_parallel(set, tolerance_mm);
    const Box3 box = set.box();
    const Vec3 middle = 0.5 * (box.low + box.high), normal = set.slices.front().plane.normal;
    std::vector<const EmptyPlane*> in_order;
    for (const EmptyPlane& one : planes) in_order.push_back(&one);
    std::sort(in_order.begin(), in_order.end(), [&](const EmptyPlane* a, const EmptyPlane* b) {
        const double p = a->plane.signed_distance(middle), q = b->plane.signed_distance(middle);
        return p != q ? p < q : a->name < b->name;
    });
    std::vector<Slice> more;
    for (const EmptyPlane* one : in_order) {
        const Place place = place_of(set, one->plane);
        if (place.crosses) not_placed.push_back(one->name);
        if (!place.is_between() || std::min(place.below, place.above) <= place.least_distance() ||
            is_given_again(one->plane, more, middle, place.least_distance()))
            continue;
        const Vec3 foot = middle - one->plane.signed_distance(middle) * one->plane.normal;
        const bool is_one_of_them =
            parallel && length(cross(normal, one->plane.normal)) * box.diagonal() <= 2 * tolerance_mm;
        more.push_back({is_one_of_them ? plane_at(set.slices.front().plane, dot(normal, foot)) : one->plane,
                        static_cast<std::uint32_t>(set.contours.size()), 0, one->name});
    }
    set.slices.insert(set.slices.end(), more.begin(), more.end());
    if (all_parallel(set, tolerance_mm)) sort_by_position(set);
    return not_placed;
}

}  // namespace anatomesh
