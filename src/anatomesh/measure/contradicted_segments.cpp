#include "anatomesh/measure/contradicted_segments.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

// A segment is steeper against a plane that it passes.
// [1; 0 to 1; M 2026-11 random sets in fans, freehand and crossing stacks]
constexpr double least_slope = 0.02;

bool passes_within(Vec3 a, Vec3 b, Vec3 p, double distance) {
    const Vec3 way = b - a;
    const double span = squared_length(way);
    const double share = span > 0 ? std::clamp(dot(p - a, way) / span, 0.0, 1.0) : 0;
    return squared_length(p - (a + share * way)) <= distance * distance;
}

// A segment of a closed contour, with what comes before and after it.
struct Passage {
    std::span<const Vec3> points;
    std::size_t index;

    Vec3 at(std::size_t steps) const { return points[(index + steps) % points.size()]; }
    Vec3 before() const { return at(points.size() - 1); }

    // Where its contour passes the plane in it.
    std::optional<Vec3> through(const Plane& plane) const {
        const Vec3 a = at(0), b = at(1);
        const double from = plane.signed_distance(a), to = plane.signed_distance(b);
        const int side_from = side(from), side_to = side(to);
        if (std::abs(from - to) < least_slope * length(b - a)) return std::nullopt;
        if (side_from * side_to < 0) return a + from / (from - to) * (b - a);
        if (side_to == 0 && side_from * side(plane.signed_distance(at(2))) < 0) return b;
        if (side_from == 0 && side_to * side(plane.signed_distance(before())) < 0) return a;
        return std::nullopt;
    }

    static int side(double distance) {
        return distance > contradiction_mm ? 1 : distance < -contradiction_mm ? -1 : 0;
    }
};

class Opponents {
  public:
    explicit Opponents(const ContourSet& contours) : contours_(contours), patches_(plane_patches(contours)) {}

    // Whether a slice whose plane the contour passes in the segment says something else of the structure
    // there.
    bool contradict(const Contour& contour, std::size_t index) const {
        const Passage passage{contours_.points_of(contour), index};
        for (std::uint32_t other = 0; other < patches_.size(); ++other) {
            if (other == contour.slice) continue;
            const std::optional<Vec3> p = passage.through(patches_[other].plane);
            if (p && reaches(patches_[other], *p) && says_otherwise(other, contour.structure, *p))
                return true;
        }
        return false;
    }

  private:
    static bool reaches(const PlanePatch& patch, Vec3 p) {
        const Vec2 q = patch.plane.to_plane(p);
        return q.x >= patch.box.low.x && q.x <= patch.box.high.x && q.y >= patch.box.low.y &&
               q.y <= patch.box.high.y;
    }

    bool says_otherwise(std::uint32_t slice, std::uint32_t structure, Vec3 p) const {
        bool draws = false;
        for (const Contour& contour : contours_.contours_of(contours_.slices[slice])) {
            if (contour.structure != structure) continue;
            draws = true;
            const std::span<const Vec3> points = contours_.points_of(contour);
            for (std::size_t n = 0; n < points.size(); ++n) {
                if (passes_within(points[n], points[(n + 1) % points.size()], p, contradiction_mm))
                    return false;
            }
        }
        return draws;
    }

    const ContourSet& contours_;
    const std::vector<PlanePatch> patches_;
};

}  // namespace

std::vector<SegmentOfContour> contradicted_segments(const ContourSet& contours,
                                                    std::span<const SegmentOfContour> segments) {
    if (segments.empty() || all_parallel(contours, parallel_tolerance_mm)) return {};
    const Opponents opponents(contours);
    std::vector<SegmentOfContour> found;
    std::copy_if(segments.begin(), segments.end(), std::back_inserter(found),
                 [&](const SegmentOfContour& segment) {
                     return opponents.contradict(contours.contours[segment.contour], segment.index);
                 });
    return found;
}

}  // namespace anatomesh
