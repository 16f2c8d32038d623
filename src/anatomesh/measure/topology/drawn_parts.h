// drawn_parts: the connected parts of what is drawn of a structure on a slice, and which of two slices
// correspond.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
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

// How a part goes on in the next slice.
struct Continuation {
    std::int32_t part = -1;          // of the next slice; -1: none, or not in a simple way
    std::uint32_t holes_closed = 0;  // of the one that end before the other, or begin after it
};

// For every part of `low` the one part of `high` that continues it: each meets no part of the other slice but
// the other, and their intersection is in one piece. Either it has as many holes as each of the two, or one
// of the two has none and the other's all lie within it: voids that close in between.
std::vector<Continuation> continued_by(const ContourSet& contours, const std::vector<DrawnPart>& low,
                                       const std::vector<DrawnPart>& high);

}  // namespace anatomesh
