// drawn_parts: the connected parts of what is drawn of a structure on a slice, and which of two slices
// correspond.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/contour_set.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

// An outer contour with the holes in it; contours by their index in the set.
struct DrawnPart {
    std::vector<std::uint32_t> contours;  // the outer one first
    Box2 box;                             // in the frame of the set's first slice
    std::size_t holes() const { return contours.size() - 1; }
};

// Of one structure on one slice, in the order of their outer contours. Requires: a kept set of parallel
// slices.
std::vector<DrawnPart> drawn_parts(const ContourSet& contours, std::uint32_t slice, std::uint32_t structure);

// For every part of `low` the index of the one part of `high` that continues it: each meets no part of the
// other slice but the other, and their intersection is in one piece with as many holes as each of the two.
// -1: there is none.
std::vector<std::int32_t> continued_by(const ContourSet& contours, const std::vector<DrawnPart>& low,
                                       const std::vector<DrawnPart>& high);

}  // namespace anatomesh
