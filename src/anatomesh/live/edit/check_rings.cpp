#include "anatomesh/live/edit/check_rings.h"

#include <cmath>
#include <utility>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/live/edit/check_drawing.h"

namespace anatomesh {

namespace {

// A point farther from its plane was not drawn on it; files round places and normals by less. [mm; > 0; D digits of files]
constexpr double most_off_plane_mm = 0.01;

Error bad_ring(const char* code, std::string message, Place place, std::string next_step) {
    return {ErrorKind::input, code, std::move(message), std::move(place), std::move(next_step)};
}

Status check_points(std::span<const Vec3> points, const Plane& plane, const std::string& contour,
                    const char* what, Place place) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (is_possible(points[i]) && std::abs(plane.signed_distance(points[i])) <= most_off_plane_mm)
            continue;
        place.contour = contour + ", " + what + " " + std::to_string(i);
        place.value = brief_point(points[i]);
        if (!is_possible(points[i]))
            return bad_ring("E-EDT-006", "a coordinate is not finite, or beyond 1e7 mm", std::move(place),
                            "correct the point");
        return bad_ring("E-EDT-005",
                        "a point lies " + brief(std::abs(plane.signed_distance(points[i]))) +
                            " mm off its plane, more than " + brief(most_off_plane_mm) + " mm",
                        std::move(place), "draw on the plane, or turn the rings with it");
    }
    return Nothing{};
}

struct SegmentOwner {
    std::uint32_t ring = 0, place = 0;
};

// Segments without length in the plane are left out: they cross nothing.
Status check_crossings(const DrawnRings& rings, const Plane& plane, Place place) {
    std::vector<Segment2> segments;
    std::vector<SegmentOwner> owners;
    segments.reserve(rings.points.size());
    owners.reserve(rings.points.size());
    for (std::uint32_t r = 0; r < rings.rings.size(); ++r) {
        const auto points = rings.points_of(rings.rings[r]);
        Vec2 last = plane.to_plane(points.back());
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec2 next = plane.to_plane(points[i]);
            if (!(next == last)) {
                segments.push_back({last, next});
                owners.push_back({r, static_cast<std::uint32_t>(i)});
            }
            last = next;
        }
    }
    const SegmentIndex index(std::move(segments));
    bool crosses = false;
    index.for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
        const Segment2 s = index.segments()[i], t = index.segments()[j];
        const SegmentContact contact = segment_contact(s.a, s.b, t.a, t.b);
        crosses = contact == SegmentContact::cross || contact == SegmentContact::overlap;
        if (crosses) {
            place.contour = std::to_string(owners[i].ring) + ", point " + std::to_string(owners[i].place);
            place.value = std::to_string(owners[j].ring) + ", point " + std::to_string(owners[j].place);
        }
        return !crosses;
    });
    if (!crosses) return Nothing{};
    return bad_ring("E-EDT-008", "a ring crosses itself or another one, or they share a stretch",
                    std::move(place), "unite the rings, or draw them again");
}

}  // namespace

bool is_possible(Vec3 p) {
    const auto within = [](double value) { return std::abs(value) <= coordinate_bound_mm; };  // false for NaN
    return within(p.x) && within(p.y) && within(p.z);
}

Status check_rings(const DrawnRings& rings, const Plane& plane, CrossingCheck crossings, const Place& place) {
    if (rings.rings.empty())
        return bad_ring("E-EDT-007", "a list without a ring", place, "remove the rings instead");
    for (std::size_t r = 0; r < rings.rings.size(); ++r) {
        const DrawnRing& ring = rings.rings[r];
        if (ring.point_count < 3) {
            Place where = place;
            where.contour = std::to_string(r);
            where.value = std::to_string(ring.point_count);
            return bad_ring("E-EDT-007", "a ring has fewer than three points", std::move(where),
                            "draw the ring, or leave it out");
        }
        ANATOMESH_CHECK_STATUS(check_points(rings.points_of(ring), plane, std::to_string(r), "point", place));
        ANATOMESH_CHECK_STATUS(
            check_points(rings.control_points_of(ring), plane, std::to_string(r), "control point", place));
    }
    return crossings == CrossingCheck::yes ? check_crossings(rings, plane, place) : Status(Nothing{});
}

}  // namespace anatomesh
