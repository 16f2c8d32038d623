#include "anatomesh/contour/walls/other_slices.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// A point so near to a slice's plane lies in it. [mm; > 0; D as group_tolerance_mm]
constexpr double on_other_slice_mm = 0.01;

}  // namespace

std::vector<Box3> boxes_of_slices(const ContourSet& set) {
    std::vector<Box3> boxes(set.slices.size());
    for (const Contour& contour : set.contours) {
        for (const Vec3& p : set.points_of(contour)) boxes[contour.slice].extend(p);
    }
    return boxes;
}

bool OtherSlices::cross(const std::vector<Vec2>& ring, const Ends& ends) const {
    std::vector<Vec3> corners;
    Box3 box;
    for (const Vec2 p : ring) {
        corners.push_back(set_.slices[slice_].plane.to_space(p));
        box.extend(corners.back());
    }
    for (std::uint32_t s = 0; s < set_.slices.size(); ++s) {
        if (s == slice_ || !meet(box, boxes_[s])) continue;
        const Plane& other = set_.slices[s].plane;
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (std::size_t k = 0; k < ring.size(); ++k) {
            const double height = other.signed_distance(corners[k]);
            const bool is_end = std::find(ends.begin(), ends.end(), ring[k]) != ends.end();
            if (is_end && std::abs(height) <= on_other_slice_mm) continue;
            low = std::min(low, height);
            high = std::max(high, height);
        }
        if (low <= on_other_slice_mm && high >= -on_other_slice_mm) return true;
    }
    return false;
}

void DrawnPolygons::add(std::vector<Vec2> polygon) {
    Box2 box;
    for (const Vec2 p : polygon) box.extend(p);
    polygons_.push_back(std::move(polygon));
    boxes_.push_back(box);
}

double DrawnPolygons::area(std::size_t loop) const {
    return signed_area(polygons_[loop]);
}

bool DrawnPolygons::is_inside(std::size_t first, std::size_t last, Vec2 p) const {
    bool inside = false;
    for (std::size_t l = first; l < last; ++l) {
        if (!boxes_[l].contains(p)) continue;
        inside ^= side_of_polygon(polygons_[l], p) == Side::inside;
    }
    return inside;
}

}  // namespace anatomesh
