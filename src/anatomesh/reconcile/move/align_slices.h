// estimate_shifts: the rigid shift of every slice in its plane by which crossing slices agree best.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// Returns the shifts of one step. They minimise the squared distances of corresponding endpoints, each
// taken across the contours, because a shift along a contour changes nothing. Huber's weights (Ann. Math.
// Stat. 35, 1964) keep a few contradictions from pulling whole slices. Of all shifts that do equally well
// the smallest are taken: a common shift of everything is none. One vector a slice, in its plane's frame.
// `shifted`: what the slices were shifted so far. The solver is conjugate gradients on the endpoints.
// Guarantees: the same bits every time.
std::vector<Vec2> estimate_shifts(const ContourSet& set, std::span<const LineComparison> comparisons,
                                  std::span<const Vec2> shifted);

// Returns the translation that all shifts have in common. Slices that move together by one translation in
// space stay as they were to each other, except for what planes cannot follow out of themselves. Taken off
// all shifts, the translation leaves the least movement in all, the sum of the lengths (geometric median;
// Weiszfeld, Tohoku Math. J. 43, 1937). So a few slices that are out of place move, and the many stay. It
// is zero unless at most 3/4 of the movement is left.
Vec3 common_translation(const ContourSet& set, std::span<const Vec2> shifts);

}  // namespace anatomesh
