// OriginalPositions: where the points of moved contours were drawn, while contours get and lose points.
#pragma once

#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Per point of a set.
struct OriginalPositions {
    std::vector<Vec3> at;        // where it was drawn; of a point put in later: where its contour was
    std::vector<bool> is_drawn;  // false: put in later
};

// The positions of a set whose points are all where they were drawn. O(points).
OriginalPositions original_positions(const ContourSet& set);

// Returns the original positions of `after`, which has the same contours with points put in, moved or
// taken out. A point that a contour of `before` has at the same place keeps its original position. So does
// a point within `reach_mm` of one that went between the same two neighbours. Any other point is taken to
// have been drawn as far from its place as those beside it were, linearly along the contour. Requires:
// contours keep their direction. O(n log n), and what went times what came between two points that stay.
OriginalPositions carry_over(const ContourSet& before, const OriginalPositions& drawn,
                             const ContourSet& after, double reach_mm);

}  // namespace anatomesh
