#include "anatomesh/contour/clean/rings_of_candidates.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// A contour that is nowhere wider has no area: digits of files. [mm; 0 to 0.01; D digits of files]
constexpr double no_width_mm = 1e-6;
// A speck has no larger box than this share of the area of a pen's loop. [1; 0 to 1; D a choice, measurement not recorded]
constexpr double speck_share = 1e-4;

// Whether all points lie within `width` of one line.
bool has_no_width(const std::vector<Vec2>& points, double width) {
    Vec2 far = points[0];
    for (Vec2 p : points) {
        if (squared_length(p - points[0]) > squared_length(far - points[0])) far = p;
    }
    const Vec2 along = far - points[0];
    const double bound = width * length(along);
    return std::all_of(points.begin(), points.end(),
                       [&](Vec2 p) { return std::abs(cross(along, p - points[0])) <= bound; });
}

// Whether the ring crosses itself and is so small all over that it is noise, whatever it bounds.
bool is_speck(std::span<const Vec2> at, double loop_mm2) {
    Box2 box;
    for (const Vec2 p : at) box.extend(p);
    if ((box.high.x - box.low.x) * (box.high.y - box.low.y) > speck_share * loop_mm2) return false;
    std::vector<Segment2> segments;
    for (std::size_t n = 0; n < at.size(); ++n) segments.push_back({at[n], at[(n + 1) % at.size()]});
    bool crosses = false;
    SegmentIndex(segments).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
        crosses = segment_contact(segments[i].a, segments[i].b, segments[j].a, segments[j].b) ==
                  SegmentContact::cross;
        return !crosses;
    });
    return crosses;
}

Error error_off_plane(const RawContours& raw, const CandidateSlice& slice, std::uint32_t c, Vec3 point,
                      double plane_repair_mm) {
    const RawContour& contour = raw.contours[c];
    const std::span<const Vec3> points{raw.points.data() + contour.first_point, contour.point_count};
    const auto index = std::find(points.begin(), points.end(), point) - points.begin();
    Place place = place_of_contour(raw, c);
    place.slice = slice.name;
    place.contour += ", point " + std::to_string(index);
    place.value = brief(std::abs(slice.plane.signed_distance(point))) + " mm";
    return {ErrorKind::input, "E-CON-005",
            "a point is more than " + brief(plane_repair_mm) + " mm away from the plane of its contour",
            std::move(place), "correct the contour, or allow a larger distance with --plane-repair"};
}

}  // namespace

Result<double> move_onto_plane(const RawContours& raw, const CandidateSlice& slice,
                               const PlaneGroupingOptions& options, Candidate& candidate, ReadingLog& log) {
    const Plane& plane = slice.plane;
    const int axis = axis_of(plane);
    double moved = 0, low = 0, high = 0;
    bool any = false;
    for (Vec3& p : candidate.points) {
        const double distance = plane.signed_distance(p);
        if (std::abs(distance) <= options.plane_tolerance_mm) {
            low = any ? std::min(low, distance) : distance;
            high = any ? std::max(high, distance) : distance;
            any = true;
            continue;
        }
        if (std::abs(distance) > options.plane_repair_mm)
            return error_off_plane(raw, slice, candidate.raw, p, options.plane_repair_mm);
        moved = std::max(moved, std::abs(distance));
        p = p - distance * plane.normal;
        // The product rounds; on a plane along two axes the third coordinate is known exactly.
        if (axis == 0) p.x = plane.origin.x;
        if (axis == 1) p.y = plane.origin.y;
        if (axis == 2) p.z = plane.origin.z;
    }
    if (moved > 0) {
        log.note(candidate.raw, "W-CON-009", "points do not lie in the plane of their contour",
                 brief(moved) + " mm", "they were projected onto slice " + slice.name);
        ContourLog& entry = log.of(candidate.raw);
        entry.max_displacement_mm = std::max(entry.max_displacement_mm, moved);
        entry.rule = "moved onto its plane";
        log.mark_repaired(candidate.raw);
        drop_repeated_points(candidate.points);
    }
    return high - low;
}

std::optional<Ring> ring_of(const RawContours& raw, const Plane& plane, double loop_mm2, Candidate candidate,
                            ReadingLog& log) {
    const std::uint32_t c = candidate.raw;
    const std::size_t points = candidate.points.size();
    Ring ring = make_ring(std::move(candidate.points), plane, c);
    ring.plane = raw.contours[c].plane;
    const std::size_t spikes = remove_spikes(ring);
    if (ring.size() < 3 || has_no_width(ring.at, no_width_mm) || is_speck(ring.at, loop_mm2)) {
        log.note(c, "W-CON-008", "the contour encloses no area", std::to_string(points) + " points",
                 "it was left out");
        log.drop(c, "no area");
        return std::nullopt;
    }
    if (spikes > 0) {
        log.note(c, "W-CON-012", "the contour has spikes, where it turns back on itself",
                 std::to_string(spikes) + (spikes == 1 ? " point" : " points"),
                 "the spikes were removed; no other point was moved");
        log.of(c).rule = "spikes removed";
        log.mark_repaired(c);
    }
    return ring;
}

}  // namespace anatomesh
