// estimate_shifts: the rigid shift of every slice in its plane by which crossing slices agree best.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// One step: the shifts that minimise the squared distances of corresponding ends, each taken across the
// contours (a shift along a contour changes nothing), with Huber's weights (Ann. Math. Stat. 35, 1964) so
// that a few contradictions do not pull whole slices; of all shifts that do equally well, the smallest: a
// common shift of everything is none. One vector a slice, in its plane's frame. Conjugate gradients on the
// ends. The same bits every time.
std::vector<Vec2> estimate_shifts(const ContourSet& set, std::span<const LineComparison> comparisons,
                                  std::span<const Vec2> shifted);

// Shifts that move all slices with the solid by one translation in space leave them as they were to each
// other, but for what planes cannot follow out of themselves. The translation that, taken off all of them,
// leaves the least movement in all (the sum of the lengths: the geometric median, Weiszfeld, Tohoku Math. J.
// 43, 1937): a few slices that are out of place with each other move then, and the many stay. Zero unless at
// most half of the movement is left.
Vec3 common_translation(const ContourSet& set, std::span<const Vec2> shifts);

}  // namespace anatomesh
