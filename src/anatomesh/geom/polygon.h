// Polygons and segments in a plane: area, and exact tests of position and contact.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// A polygon is the cycle of its vertices; the first is not repeated at the end.

// Area, positive if counter-clockwise; rounded. Vertices are taken relative to the first, so that a polygon
// far from the origin loses nothing. 0 for fewer than three vertices. O(n).
double signed_area(std::span<const Vec2> polygon);

// Sum of the edges' lengths. O(n).
double perimeter(std::span<const Vec2> polygon);

enum class Side : std::uint8_t { outside, on_boundary, inside };

// Where a point lies by the even-odd rule, exactly: the polygon may cross itself. O(n).
Side side_of_polygon(std::span<const Vec2> polygon, Vec2 point);

// How two closed segments meet, exactly.
enum class SegmentContact : std::uint8_t {
    none,
    touch,   // in one point that is an end of at least one of them
    cross,   // in one point inside both
    overlap  // along a segment of positive length
};

// Requires: a != b, c != d. Symmetric in the two segments and in the ends of each.
SegmentContact segment_contact(Vec2 a, Vec2 b, Vec2 c, Vec2 d);

// From p to the nearest point of the closed segment ab; rounded.
double distance_to_segment(Vec2 p, Vec2 a, Vec2 b);

// Whether p lies on the closed segment ab, exactly.
bool on_segment(Vec2 a, Vec2 b, Vec2 p);

// Total order by x, then y.
inline bool lexicographic_less(Vec2 a, Vec2 b) {
    return a.x != b.x ? a.x < b.x : a.y < b.y;
}

}  // namespace anatomesh
