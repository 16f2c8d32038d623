// find_doubled_rings: rings of one structure in one slice that follow each other everywhere.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/ring.h"

namespace anatomesh {

// Two rings, the smaller area first, that keep within `apart_mm` of each other.
struct DoubledRings {
    std::uint32_t smaller = 0, larger = 0;
    double apart_mm = 0;
};

// The pairs of rings on one declared plane of which every vertex of each lies within `within_mm` of the
// other, and within half of the mean edge length of both or `of_radius` radii (of the smaller one: twice its
// area over its length), whichever is more. A hand follows an outline more closely than its vertices are
// apart only where it draws it again, while the two faces of a thin wall are drawn with vertices as fine as
// the wall; but whether a wall far thinner than what it encloses is one, vertices do not tell. Pairs are
// ordered by `smaller` in descending area (then by place in `rings`), then by `larger`. Distances by plain
// floating point: nothing of topology depends on them. Requires: rings of three vertices or more. Complexity:
// O(n log n) in the vertices of rings whose boxes and areas are near, and the pairs of those that near to
// each other; besides, O(r log r) in the rings and the pairs of them with one left end.
std::vector<DoubledRings> find_doubled_rings(std::span<const Ring> rings, double within_mm,
                                             double of_radius = 0);

}  // namespace anatomesh
