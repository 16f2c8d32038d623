// estimate_shifts: the rigid shift of every slice in its plane by which crossing slices agree best.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/contour/contour_set.h"
#include "anatomesh/reconcile/line_ends.h"

namespace anatomesh {

// One step: the shifts that minimise the squared distances of corresponding ends, each taken across the
// contours (a shift along a contour changes nothing), with Huber's weights (Ann. Math. Stat. 35, 1964) so
// that a few contradictions do not pull whole slices; of all shifts that do equally well, the smallest: a
// common shift of everything is none. One vector a slice, in its plane's frame. Conjugate gradients on the
// ends. The same bits every time.
std::vector<Vec2> estimate_shifts(const ContourSet& set, std::span<const LineComparison> comparisons,
                                  std::span<const Vec2> shifted);

}  // namespace anatomesh
