// Closing corridors and moving rings apart: the two repairs of rings that may move a vertex.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/ring.h"

namespace anatomesh {

// A keyhole contour joins a hole to its outer contour by two edges that run back along each other. Where two
// such edges (each at least twice, a chain of them ten times the width long) lie at most `width` apart with
// the outside between them, the second takes the first's vertices, so that the corridor has width 0; with the
// inside between them only below 1e-6 mm (a hair). Returns the largest move, 0 when there was nothing to do.
// Complexity: O(n log n); of vertices crowded within the width 64 are looked at.
double close_corridors(Ring& ring, double width);

// The same where a person or a program drew the corridor with a width: two edges, each at least ten times as
// long as they are apart at their ends, at most `width`, the outside between them, and the ring between
// one's end and the other's beginning turns the other way round and bounds more than the corridor: a hole.
// Edges that cross by at most `crossing` count too. Complexity: that of close_corridors.
double close_keyholes(Ring& ring, double width, double crossing);

// What separate_rings did at one ring.
struct Separation {
    std::uint32_t ring = 0;      // index into the rings
    std::uint32_t vertices = 0;  // that it shared
    double displacement_mm = 0;  // how far the line is from a vertex that was there, at most
};

// Where rings share a vertex, all but the largest leave it: a sharp corner is cut off at `distance`, of a
// blunt one the vertex goes as far along the bisector of their own polygon's angle, and the edges bend near
// it. By less where edges there are short (a quarter), where that would make rings meet or another one lies
// in what is cut off, and where a smaller ring lies in the angle. Requires: simple rings that meet in common
// vertices only. Returns false when no room was found.
bool separate_rings(std::vector<Ring>& rings, const Plane& plane, double distance,
                    std::vector<Separation>& done);

}  // namespace anatomesh
