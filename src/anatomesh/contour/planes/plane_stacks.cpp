#include "anatomesh/contour/planes/plane_stacks.h"

#include <algorithm>

#include "anatomesh/contour/planes/plane_fit.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

namespace {

double declared_offset(const ContourToPlace& contour, const Plane& plane, Vec3 normal) {
    if (cross(plane.normal, normal) == Vec3{}) return dot(plane.origin, normal);
    Box3 box;
    for (const Vec3& p : contour.points) box.extend(p);
    const Vec3 center = 0.5 * (box.low + box.high);
    return dot(center - plane.signed_distance(center) * plane.normal, normal);
}

// The offset that half the points of a run of contours reach.
double common_offset(std::span<const PositionedContour> run) {
    std::size_t all = 0, seen = 0;
    for (const PositionedContour& p : run) all += p.points;
    for (const PositionedContour& p : run) {
        seen += p.points;
        if (2 * seen >= all) return p.offset;
    }
    return run.back().offset;
}

}  // namespace

std::vector<PlaneStack> plane_stacks(std::span<const ContourToPlace> contours,
                                     std::span<const Plane> declared,
                                     const ContourOrientations& orientations) {
    std::vector<PlaneStack> of_orientation;
    for (const Orientation& orientation : orientations.all)
        of_orientation.push_back({orientation.normal, {}});
    for (std::size_t c = 0; c < contours.size(); ++c) {
        PlaneStack& stack = of_orientation[static_cast<std::size_t>(orientations.of_contour[c])];
        const ContourToPlace& contour = contours[c];
        const double offset =
            contour.plane >= 0
                ? declared_offset(contour, declared[static_cast<std::size_t>(contour.plane)], stack.normal)
                : fit_along(contour.points, stack.normal).offset;
        stack.contours.push_back({offset, static_cast<std::uint32_t>(c), contour.points.size()});
    }
    std::erase_if(of_orientation, [](const PlaneStack& stack) { return stack.contours.empty(); });
    std::stable_sort(
        of_orientation.begin(), of_orientation.end(),
        [](const PlaneStack& p, const PlaneStack& q) { return lexicographic_less(p.normal, q.normal); });
    for (PlaneStack& stack : of_orientation) {
        std::stable_sort(
            stack.contours.begin(), stack.contours.end(),
            [](const PositionedContour& p, const PositionedContour& q) { return p.offset < q.offset; });
    }
    return of_orientation;
}

double same_plane_mm(std::span<const PositionedContour> stack, double extent_mm, double bound_mm) {
    // Of the largest gap. [1; 0 to 0.5; D a choice, measurement not recorded]
    constexpr double share_of_gap = 0.02;
    // Of the extent, for two planes. [1; 0 to 1; D a choice, measurement not recorded]
    constexpr double share_of_extent = 1e-3;
    // Of the extent: less is no gap. [1; 0 to 1; D a choice, measurement not recorded]
    constexpr double rounding_share = 1e-5;
    const double rounding = rounding_share * extent_mm;
    double largest_gap = 0;
    std::size_t planes = 1;
    for (std::size_t i = 1; i < stack.size(); ++i) {
        const double gap = stack[i].offset - stack[i - 1].offset;
        if (gap <= rounding) continue;
        ++planes;
        largest_gap = std::max(largest_gap, gap);
    }
    if (planes <= 2) return std::min(bound_mm, share_of_extent * extent_mm);
    return std::min(bound_mm, std::max(rounding, share_of_gap * largest_gap));
}

Plane common_plane(std::span<const PositionedContour> run, Vec3 normal) {
    // Adding 0.0 turns a negative zero positive.
    const Vec3 origin = common_offset(run) * normal;
    return make_plane({origin.x + 0.0, origin.y + 0.0, origin.z + 0.0}, normal);
}

}  // namespace anatomesh
