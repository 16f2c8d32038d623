// When contours beside a line of many planes are regularized: what regularize_fans and regularize_along_axis
// share.
#pragma once

#include <cstddef>

namespace anatomesh {

// An axis has this many planes or more; beside a line of fewer they are far enough apart. [planes; >= 3;
// M 2026-11 69 random sets about an axis]
inline constexpr std::size_t planes_at_axis = 4;
// Directions that differ by less are one axis, for planes as files give them. [1, sine; 0 to 1; D]
inline constexpr double same_axis_sine = 1e-6;
// Contours are led by their neighbours only if those are not farther apart, about the axis.
// [degrees; 0 to 180; M 2026-11 69 random sets about an axis]
inline constexpr double widest_gap_degrees = 150;
// Contours go half of their way in each step, and have as good as all of it after so many. [steps; >= 1; B]
inline constexpr int most_regularizing_steps = 50;

}  // namespace anatomesh
