// close_corridors, close_keyholes and separate_rings: the repairs of rings that may move a vertex.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/ring.h"

namespace anatomesh {

// A keyhole contour joins a hole to its outer contour by two edges that run back along each other. Two such edges lie
// at most `width` apart with the outside between them; each is at least twice as long as the width, a chain of them
// ten times. The second takes the first's vertices, so that the corridor has width 0. With the inside between them
// this is done only below 1e-6 mm, for a hair. Returns the largest move in mm, 0 when there was nothing to do.
// Complexity: O(n log n); of vertices crowded within the width 64 are looked at.
double close_corridors(Ring& ring, double width);

// Closes corridors that a person or a program drew with a width. Such a corridor is two edges with the outside between
// them, at most `width` apart at their ends and at least ten times as long. The ring between one's end and the other's
// beginning turns the other way round and bounds more than the corridor, so it is a hole. Edges that cross by at most
// `crossing` count too. Complexity: that of close_corridors.
double close_keyholes(Ring& ring, double width, double crossing);

// What separate_rings did at one ring.
struct Separation {
    std::uint32_t ring = 0;      // index into the rings
    std::uint32_t vertices = 0;  // that it shared
    double displacement_mm = 0;  // how far the line is from a vertex that was there, at most
};

// Where rings share a vertex, all but the largest leave it. A sharp corner is cut off at `distance`. The vertex of a
// blunt one goes as far along the bisector of its own polygon's angle, and the edges bend near it. The distance is less
// where edges are short (a quarter of them), and where a smaller ring lies in the angle. It is also less where rings
// would meet, or where another one lies in what is cut off. Vertices nearer to a shared one than a tenth of the distance
// go with it, so that edges of rounding's length leave room. Requires: simple rings that meet in common vertices only. Returns false when no
// room was found. O(n log n) for few shared vertices.
bool separate_rings(std::vector<Ring>& rings, const Plane& plane, double distance,
                    std::vector<Separation>& done);

}  // namespace anatomesh
