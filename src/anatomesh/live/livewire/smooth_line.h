// smooth_line: takes the steps from pixel to pixel out of a line.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Returns a line or ring with as many points, each moved towards the mean of its neighbours four times over. No point
// leaves its pixel: it moves by half a step at most along each axis. The ends of an open line do not move.
// Requires: points are centres of pixels with these steps, in mm. O(points).
// Source: Gaussian smoothing by repeated binomial filters (Wells, IEEE PAMI 8, 1986).
std::vector<Vec2> smooth_line(std::span<const Vec2> points, bool closed, Vec2 step);

}  // namespace anatomesh
