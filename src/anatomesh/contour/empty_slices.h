// keep_empty_slices: planes that a file gives and draws nothing on.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/contour/contour_set.h"

namespace anatomesh {

// How a message calls a slice: by the name that the file gives it, else by its position along an axis, else
// by its number.
std::string slice_text(const Plane& plane, const std::string& given, std::size_t number);

struct EmptyPlane {
    Plane plane;
    std::string name;
};

struct EmptySlices {
    std::vector<std::string> kept;        // slices of the set now
    std::vector<std::string> not_placed;  // planes that cross others: how far they reach is not known
};

// Adds the planes to a set of parallel slices, each as a slice without contours: what a file names and draws
// nothing on is empty there (the cross-section formats' rule; Bermano et al. 2011 read it so). Not those
// before the first and after the last slice with contours, which the end caps stand for, nor those nearer to
// a slice with contours, or to one another, than `least_gap` of the median spacing: they are one slice. Where
// planes cross, a plane tells of its own contours' extent only, and an empty one has none. Requires: slices
// in order of position. Guarantees: a kept set stays one; what is in it does not depend on the planes' order.
// Complexity: O(n log n) in slices and planes, O(contours).
EmptySlices keep_empty_slices(ContourSet& set, std::span<const EmptyPlane> planes,
                              double parallel_tolerance_mm);

}  // namespace anatomesh
