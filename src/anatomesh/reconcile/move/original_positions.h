// OriginalPositions: where the points of moved contours were drawn, kept up as the contours get and lose
// points.
#pragma once

#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Per point of a set.
struct OriginalPositions {
    std::vector<Vec3> at;        // where it was drawn; of a point put in later: where its contour was
    std::vector<bool> is_drawn;  // false: put in later
};

OriginalPositions original_positions(const ContourSet& set);

// Those of `after`, the same contours with points put in, moved or taken out: points that a contour of
// `before` has at the same place keep theirs, and so do those within `reach_mm` of one that went between the
// same two. Others were drawn as far from their place as these are, linearly along the contour between the
// two beside them. Requires: contours keep their direction. O(n log n), and what went times what came between
// two points that stay.
OriginalPositions carry_over(const ContourSet& before, const OriginalPositions& drawn,
                             const ContourSet& after, double reach_mm);

}  // namespace anatomesh
