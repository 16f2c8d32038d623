// Polygons and segments in a plane: area, and exact tests of position and contact.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// A polygon is the cycle of its vertices; the first is not repeated at the end.

// Returns the rounded area, positive if counter-clockwise; 0 for fewer than three vertices. Vertices are taken relative
// to the first, so that a polygon far from the origin loses nothing. O(n).
double signed_area(std::span<const Vec2> polygon);

// Returns the sum of the edges' lengths. O(n).
double perimeter(std::span<const Vec2> polygon);

enum class Side : std::uint8_t { outside, on_boundary, inside };

// Returns exactly on which side of the polygon a point lies by the even-odd rule; the polygon may cross itself. O(n).
Side side_of_polygon(std::span<const Vec2> polygon, Vec2 point);

// The way in which two closed segments meet.
enum class SegmentContact : std::uint8_t {
    none,
    touch,   // in one point that is an end of at least one of them
    cross,   // in one point inside both
    overlap  // along a segment of positive length
};

// Returns exactly how ab and cd meet; it is symmetric in the two segments and in the ends of each. Requires: a != b,
// c != d. O(1).
SegmentContact segment_contact(Vec2 a, Vec2 b, Vec2 c, Vec2 d);

// Returns the rounded distance from p to the nearest point of the closed segment ab. O(1).
double distance_to_segment(Vec2 p, Vec2 a, Vec2 b);

// Whether p lies on the closed segment ab, exactly.
bool on_segment(Vec2 a, Vec2 b, Vec2 p);

// A total order by x, then y.
inline bool lexicographic_less(Vec2 a, Vec2 b) {
    return a.x != b.x ? a.x < b.x : a.y < b.y;
}

}  // namespace anatomesh
