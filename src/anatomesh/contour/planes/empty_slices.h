// keep_empty_slices: planes that a file gives and draws nothing on.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// How a message calls a slice: by the name that the file gives it, else by its position along an axis, else
// by its number.
std::string slice_text(const Plane& plane, const std::string& given, std::size_t number);

struct EmptyPlane {
    Plane plane;
    std::string name;
};

// Adds the planes to a stack or a sweep, each as a slice without contours: what a file names and draws
// nothing on is empty there (the cross-section formats' rule; Bermano et al. 2011 read it so). A plane is
// added if all that is drawn on any one slice lies on one side of it, and something on either: not one before
// the first or after the last slice, which the end caps stand for. Nor one that is nearer to what is drawn on
// one side than a twentieth of the way to what is drawn on the other, or to another one of these than that:
// they are one slice. Where it runs through what is drawn on another slice it is not placed: a plane tells of
// its own contours' extent only, and an empty one has none; returns the names of such planes. Guarantees: a
// kept set stays one, parallel slices in order of position, the added ones last where they are not parallel;
// what is in it does not depend on the planes' order. Complexity: O(planes * (points + planes)).
std::vector<std::string> keep_empty_slices(ContourSet& set, std::span<const EmptyPlane> planes,
                                           double tolerance_mm);

}  // namespace anatomesh
