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

// Returns the pairs of rings on one declared plane that keep near each other. Every vertex of each lies within
// `within_mm` of the other. It also lies within half of the mean edge length of both, or within `of_radius` radii of
// the smaller one, whichever is more. A radius is twice the area over the length.
// A hand follows an outline more closely than its vertices are apart only where it draws it again. The two faces of a
// thin wall are drawn with vertices as fine as the wall. Vertices do not decide whether a wall far thinner than
// what it encloses is one.
// Pairs are ordered by `smaller` in descending area, then by place in `rings`, then by `larger`. Distances are rounded,
// because nothing of topology depends on them. Requires: rings of three vertices or more. Complexity: O(r log r) in the
// rings, and O(n log n) in the vertices of pairs whose boxes and areas are near.
std::vector<DoubledRings> find_doubled_rings(std::span<const Ring> rings, double within_mm,
                                             double of_radius = 0);

}  // namespace anatomesh
