// StructureRings: what is drawn of one structure on one plane, and the check that it is sound.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/ring.h"

namespace anatomesh {

// A point of a ring farther from its plane is refused. [mm; 0 to 1; D digits of files]
inline constexpr double ring_off_plane_mm = 0.01;
// A frame is orthonormal if products of its axes differ by no more. [1; 0 to 1e-3; D digits of files]
inline constexpr double frame_rounding = 1e-6;
// More edges on one plane are refused. [edges; > 0; B]
inline constexpr std::size_t most_drawn_edges = 300'000;
// The source of a ring that comes from no ring before it. [index; largest number; D]
inline constexpr std::uint32_t drawn_now = 0xffffffff;

// The region of the structure is the even-odd interior of all rings together, so a ring inside another one is a hole,
// and a ring in a hole is an island. Rings run in either direction, in any order. They are sound if
// check_structure_rings() says so; every function of this room requires sound rings and returns sound rings.
struct StructureRings {
    Plane plane;
    std::vector<Ring> rings;
};

// Returns the rings of closed polygons, in their order; the first vertex is not repeated. Points in space are kept bit
// for bit, and source i is polygon i. Errors: those of check_structure_rings(). O(n log n).
Result<StructureRings> make_structure_rings(std::span<const std::vector<Vec3>> polygons, const Plane& plane);

// Whether the rings are sound. Every ring is simple. Two rings do not cross and share no part of an edge; they may
// touch in points. Contacts are exact on in-plane coordinates. Errors, with the ring and its point as the place: input
// E-LIV-001 a coordinate is not finite or beyond 1e7 mm, E-LIV-002 fewer than three points, E-LIV-003 a point is off
// the plane by more than ring_off_plane_mm, E-LIV-006 the frame of the plane is not orthonormal; geometry E-LIV-004 a
// ring touches or crosses itself, E-LIV-005 two rings cross or share an edge; limit E-LIV-007 more than
// most_drawn_edges edges. Complexity: O(n log n) for rings that keep apart.
Status check_structure_rings(const StructureRings& drawn);

// Checks points of a plane before a tool uses them. `what` is the subject of the message, as in "the stroke". Errors:
// input E-LIV-001 a coordinate is not finite or beyond 1e7 mm, limit E-LIV-007 more than most_drawn_edges points. O(n).
Status check_points(std::span<const Vec2> points, const std::string& what);

// Checks an option that has to be a finite number within [low, high]. Error: usage E-LIV-008 it is not.
Status check_option(double value, double low, double high, const std::string& name);

// The error of lines that cross too often, or so that rounding does not come to rest: limit E-LIV-007.
Error crosses_too_often();

// Whether the point lies in the region or on its boundary. Exact. O(n).
bool lies_in(const StructureRings& drawn, Vec2 point);

// Whether the rings are the same, bit for bit and in the same order. O(n).
bool are_same(std::span<const Ring> p, std::span<const Ring> q);

// Returns a ring of these points of the plane, without points equal to the one before. Its source is drawn_now. O(n).
Ring ring_of(std::span<const Vec2> polygon, const Plane& plane);

}  // namespace anatomesh
