// keep_empty_slices: planes that a file gives without drawing anything on them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Returns the name of a slice in messages: the one that the file gives it, else its position along an axis, else its
// number.
std::string slice_text(const Plane& plane, const std::string& given, std::size_t number);

struct EmptyPlane {
    Plane plane;
    std::string name;
};

// Adds the planes to a stack or a sweep, each as a slice without contours. A plane that a file names and draws nothing on
// is empty there, as the cross-section formats and Bermano et al. 2011 have it.
// A plane is added if all that is drawn on any one slice lies on one side of it, and something lies on either side. So
// no plane before the first or after the last slice is added; end caps stand for these. A plane is one slice with what
// is drawn on one side if it is nearer to it than a twentieth of the way to the other side. It is then not added, nor
// where another added plane is as near. A plane that runs through what is drawn on another slice is not placed. It
// counts within its own contours' extent only, and an empty plane has none. Returns the names of such planes.
// Guarantees: a kept set stays one. Parallel slices are in order of position; else the added ones come last. The result
// does not depend on the planes' order. Complexity: O(planes * (points + planes)).
std::vector<std::string> keep_empty_slices(ContourSet& set, std::span<const EmptyPlane> planes,
                                           double tolerance_mm);

}  // namespace anatomesh
