// PlanePatch: the part of a slice's plane on which its contours say something.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

// The box of the slice's contours in the frame of its plane, and how far their points lie off the plane.
// Grown by a margin, it is where everything that is not drawn is outside; beyond it the plane says nothing.
struct PlanePatch {
    Plane plane;
    Box2 box;                  // empty without contours
    double low = 0, high = 0;  // of the contour points along the normal

    std::array<Vec3, 4> corners() const {
        return {plane.to_space(box.low), plane.to_space({box.high.x, box.low.y}), plane.to_space(box.high),
                plane.to_space({box.low.x, box.high.y})};
    }

    // From p to the nearest point of the patch grown by `margin` in its plane.
    Vec3 offset_from(Vec3 p, double margin) const {
        const Vec2 q = plane.to_plane(p);
        const double h = plane.signed_distance(p);
        const double x = std::clamp(q.x, box.low.x - margin, box.high.x + margin) - q.x;
        const double y = std::clamp(q.y, box.low.y - margin, box.high.y + margin) - q.y;
        return x * plane.u + y * plane.v + (std::clamp(h, low, high) - h) * plane.normal;
    }
};

// One patch a slice. O(points).
std::vector<PlanePatch> plane_patches(const ContourSet& set);

// The box of each slice's contours with those of all others parallel to it (within 0.1 degrees: images of one
// series have one frame) that have three quarters of it in theirs: they draw beside what it draws, and what
// it does not draw there is not there. Slices that draw something else alone may be of other images. But not
// where, or within a margin of where, slices of other directions draw something in the plane: which of them
// is right cannot be told. Others have their own boxes; so have slices by hand, whose frame is not known.
// Complexity: O(slices^2), and O(slices * points) where there are such.
std::vector<Box2> frames_of_slices(const ContourSet& set, const std::vector<PlanePatch>& patches,
                                   double margin);

// Planes that cross are dense where vertices along the contours are more than so many spacings apart: then
// contours show less than planes do. [plane spacings; > 0; M 2026-11 dense freehand planes]
inline constexpr double dense_spacing = 1.5;

struct PlaneSpacings {
    double median = 0, wide = 0;  // mm; nine tenths of the places have a neighbour within `wide`
    double gap = 0;  // mm; 995 of 1000 places have one within it on either side where there is any
};

// How far contour vertices are from the nearest plane that runs within 30 degrees of their own, on a sample
// of them, or half as far as from the fourth nearest, of both medians the larger: planes drawn freehand
// cross; where there is no such plane, the set's diagonal shared by the planes. O(planes^2) with a small
// factor.
PlaneSpacings plane_spacings(const ContourSet& set, const std::vector<PlanePatch>& patches);

// The frames with the median spacing as the margin.
std::vector<Box2> frames_of_slices(const ContourSet& set);

// The mean distance of neighbouring vertices along the contours; 0 without contours.
double mean_vertex_spacing(const ContourSet& set);

// Pairs (a, b), a < b, of planes that are not parallel and whose patches, grown by the margin, meet their
// common line. In rising order. Sweep along an axis over the patches' boxes: O(n log n + pairs whose boxes
// overlap).
std::vector<std::pair<std::uint32_t, std::uint32_t>> crossing_pairs(const std::vector<PlanePatch>& patches,
                                                                    double margin);

}  // namespace anatomesh
