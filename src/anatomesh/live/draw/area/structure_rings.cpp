#include "anatomesh/live/draw/area/structure_rings.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/standard_arithmetic.h"
#include "anatomesh/contour/overlay/nesting.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

bool is_in_bounds(double value) {
    return std::abs(value) <= coordinate_bound_mm;  // false for what is not a number
}

bool is_in_bounds(Vec3 p) {
    return is_in_bounds(p.x) && is_in_bounds(p.y) && is_in_bounds(p.z);
}

Place place_of(std::size_t ring, std::size_t point, std::string value = {}) {
    Place place;
    place.contour = std::to_string(ring) + ", point " + std::to_string(point);
    place.value = std::move(value);
    return place;
}

Error bad_coordinate(Place place) {
    return {ErrorKind::input, "E-LIV-001", "a coordinate is not a number or beyond 1e7 mm", std::move(place),
            "check the unit and the transform of the points"};
}

Error too_many_edges(const std::string& what) {
    return {ErrorKind::limit,
            "E-LIV-007",
            what + " has more than " + std::to_string(most_drawn_edges) + " points",
            {},
            "draw with fewer points"};
}

Status check_plane(const Plane& plane) {
    for (const Vec3 v : {plane.origin, plane.u, plane.v, plane.normal}) {
        Place place;
        place.value = "plane";
        if (!is_in_bounds(v)) return bad_coordinate(std::move(place));
    }
    const double errors[] = {dot(plane.u, plane.u) - 1, dot(plane.v, plane.v) - 1,
                             dot(plane.normal, plane.normal) - 1, dot(plane.u, plane.v),
                             length(cross(plane.u, plane.v) - plane.normal)};
    for (const double error : errors) {
        if (std::abs(error) <= frame_rounding) continue;
        return Error{ErrorKind::input,
                     "E-LIV-006",
                     "the axes of the plane are not orthonormal and right-handed",
                     {},
                     "give a plane with unit axes at right angles"};
    }
    return Nothing{};
}

Status check_ring(const Ring& ring, std::size_t number, const Plane& plane) {
    assert(ring.at.size() == ring.points.size());
    for (std::size_t i = 0; i < ring.size(); ++i) {
        if (!is_in_bounds(ring.points[i])) return bad_coordinate(place_of(number, i));
        const double off = std::abs(plane.signed_distance(ring.points[i]));
        if (off <= ring_off_plane_mm) continue;
        return Error{ErrorKind::input, "E-LIV-003", "a point of a ring is off its plane",
                     place_of(number, i, brief(off) + " mm"),
                     "give points within " + brief(ring_off_plane_mm) + " mm of the plane"};
    }
    if (ring.size() < 3) {
        return Error{ErrorKind::input, "E-LIV-002", "a ring has fewer than three points",
                     place_of(number, 0, std::to_string(ring.size())), "remove the ring"};
    }
    for (std::size_t i = 0; i < ring.size(); ++i) {
        if (ring.at[i] != ring.at[i + 1 < ring.size() ? i + 1 : 0]) continue;
        return Error{ErrorKind::geometry, "E-LIV-004", "two points of a ring in turn are equal",
                     place_of(number, i), "remove one of them"};
    }
    return Nothing{};
}

// Whether the direction from x to c lies between those to a and b, counter-clockwise from a. Requires: all differ.
bool is_between(Vec2 x, Vec2 a, Vec2 b, Vec2 c) {
    const int turn = orient2d(x, a, b);
    if (turn > 0) return orient2d(x, a, c) > 0 && orient2d(x, c, b) > 0;
    if (turn == 0) return orient2d(x, a, c) > 0;
    return !(orient2d(x, b, c) >= 0 && orient2d(x, c, a) >= 0);
}

// The two points that a ring goes to from its point x, which lies on the segment from vertex `place` on.
std::pair<Vec2, Vec2> ways_from(const Ring& ring, std::size_t place, Vec2 x) {
    const std::size_t n = ring.size(), next = (place + 1) % n;
    if (x == ring.at[place]) return {ring.at[(place + n - 1) % n], ring.at[next]};
    if (x == ring.at[next]) return {ring.at[place], ring.at[(next + 1) % n]};
    return {ring.at[place], ring.at[next]};
}

// Whether two rings cross in the one point that segments i and j of them have in common.
bool cross_where_they_touch(const RingEdges& edges, std::span<const Ring> rings, std::uint32_t i,
                            std::uint32_t j) {
    const Segment2 &s = edges.index.segments()[i], &t = edges.index.segments()[j];
    const std::uint32_t p = edges.ring_of[i], q = edges.ring_of[j];
    const Vec2 x = on_segment(t.a, t.b, s.a)   ? s.a
                   : on_segment(t.a, t.b, s.b) ? s.b
                   : on_segment(s.a, s.b, t.a) ? t.a
                                               : t.b;
    const auto [a, b] = ways_from(rings[p], i - edges.first[p], x);
    const auto [c, d] = ways_from(rings[q], j - edges.first[q], x);
    if (c == a || c == b || d == a || d == b) return false;  // they share an edge, which is found as such
    return is_between(x, a, b, c) != is_between(x, a, b, d);
}

// What is wrong with the way in which segments i and j of the rings meet, if anything.
Status check_contact(const RingEdges& edges, std::span<const Ring> rings, std::uint32_t i, std::uint32_t j) {
    const Segment2 &s = edges.index.segments()[i], &t = edges.index.segments()[j];
    const SegmentContact contact = segment_contact(s.a, s.b, t.a, t.b);
    if (contact == SegmentContact::none) return Nothing{};
    const std::uint32_t p = edges.ring_of[i], q = edges.ring_of[j];
    if (p != q) {
        if (contact == SegmentContact::touch && !cross_where_they_touch(edges, rings, i, j)) return Nothing{};
        const bool crosses = contact != SegmentContact::overlap;
        return Error{ErrorKind::geometry, "E-LIV-005",
                     crosses ? "two rings cross" : "two rings share a part of an edge",
                     place_of(p, i - edges.first[p], "ring " + std::to_string(q)), "unite the rings first"};
    }
    const bool consecutive = j == i + 1 || (i == edges.first[p] && j + 1 == i + rings[p].size());
    if (consecutive && contact == SegmentContact::touch) return Nothing{};
    return Error{ErrorKind::geometry, "E-LIV-004",
                 contact == SegmentContact::cross ? "a ring crosses itself" : "a ring touches itself",
                 place_of(p, i - edges.first[p]), "draw the ring as a stroke, which mends it"};
}

}  // namespace

Result<StructureRings> make_structure_rings(std::span<const std::vector<Vec3>> polygons, const Plane& plane) {
    const StandardArithmetic arithmetic;
    StructureRings drawn{plane, {}};
    for (std::size_t i = 0; i < polygons.size(); ++i) {
        drawn.rings.push_back(make_ring(polygons[i], plane, static_cast<std::uint32_t>(i)));
    }
    ANATOMESH_CHECK_STATUS(check_structure_rings(drawn));
    return drawn;
}

Status check_structure_rings(const StructureRings& drawn) {
    const StandardArithmetic arithmetic;
    ANATOMESH_CHECK_STATUS(check_plane(drawn.plane));
    std::size_t count = 0;
    for (const Ring& ring : drawn.rings) count += ring.size();
    if (count > most_drawn_edges) return too_many_edges("the plane");
    for (std::size_t r = 0; r < drawn.rings.size(); ++r) {
        ANATOMESH_CHECK_STATUS(check_ring(drawn.rings[r], r, drawn.plane));
    }
    const RingEdges edges(drawn.rings);
    Status sound = Nothing{};
    edges.index.for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
        sound = check_contact(edges, drawn.rings, i, j);
        return sound.ok();
    });
    return sound;
}

Status check_points(std::span<const Vec2> points, const std::string& what) {
    if (points.size() > most_drawn_edges) return too_many_edges(what);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (is_in_bounds(points[i].x) && is_in_bounds(points[i].y)) continue;
        Place place;
        place.value = what + ", point " + std::to_string(i);
        return bad_coordinate(std::move(place));
    }
    return Nothing{};
}

Status check_option(double value, double low, double high, const std::string& name) {
    if (value >= low && value <= high) return Nothing{};
    Place place;
    place.value = number_text(value);
    return Error{ErrorKind::usage, "E-LIV-008", name + " is outside its range", std::move(place),
                 "give " + number_text(low) + " to " + number_text(high)};
}

Error crosses_too_often() {
    return {
        ErrorKind::limit, "E-LIV-007", "the lines of the plane cross too often", {}, "draw shorter strokes"};
}

bool lies_in(const StructureRings& drawn, Vec2 point) {
    bool inside = false;
    for (const Ring& ring : drawn.rings) {
        const Side side = side_of_polygon(ring.at, point);
        if (side == Side::on_boundary) return true;
        if (side == Side::inside) inside = !inside;
    }
    return inside;
}

bool are_same(std::span<const Ring> p, std::span<const Ring> q) {
    return std::equal(p.begin(), p.end(), q.begin(), q.end(),
                      [](const Ring& a, const Ring& b) { return a.points == b.points && a.at == b.at; });
}

Ring ring_of(std::span<const Vec2> polygon, const Plane& plane) {
    Ring ring;
    ring.source = drawn_now;
    for (const Vec2 q : polygon) {
        const Vec3 point = plane.to_space(q);
        const Vec2 at = plane.to_plane(point);
        if (ring.at.empty() || ring.at.back() != at) ring.push_back(at, point);
    }
    while (ring.size() > 1 && ring.at.back() == ring.at.front()) ring.at.pop_back(), ring.points.pop_back();
    return ring;
}

}  // namespace anatomesh
