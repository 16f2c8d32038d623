// wall_size: the edge length that structures ask for which run close beside each other.
#pragma once

#include <optional>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct WallSize {
    double size_mm = 0;
    double thickness_mm = 0;  // of the walls, in the median
    double cells = 0;         // that it makes, by estimate: 75 for each square of it on the surfaces
    double share = 0;         // of all that is drawn, by length, that belongs to such structures
};

// Returns the edge length for structures that run close beside others. Such a structure has half of its vertices
// within a fifth of `size_mm` of another structure's contour in their slice, but not on it. The edge length is 2.5
// times the median of these distances; of several structures the least counts. Returns nothing if there is none, or if
// that is more than 0.7 sizes. `size_mm` is the edge length that would do without these walls.
// The space between two such surfaces is a wall everywhere. A mesh of longer edges has flat cells in it or none, however
// its points are put. (Nested ellipsoids 0.1 and 0.2 mm apart on four kinds of planes made 40 to 75 cells for each
// square.) At most 64 vertices of a contour are looked at. Requires: size_mm > 0; spacing_mm > 0,
// between slices. Complexity: O(contours * points of a slice).
std::optional<WallSize> wall_size(const ContourSet& contours, double size_mm, double spacing_mm);

}  // namespace anatomesh
