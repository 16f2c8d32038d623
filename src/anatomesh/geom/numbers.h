// Numbers of geometry that several rooms use: each has its one home here.
#pragma once

#include <numbers>

namespace anatomesh {

// Coordinates further from the origin are refused as damaged: doubles keep a micrometre and more within it.
// [mm; > 0; C]
inline constexpr double coordinate_bound_mm = 1e7;

// It turns degrees into radians. [radians per degree; one value; D]
inline constexpr double radians_per_degree = std::numbers::pi / 180;
// It turns radians into degrees. [degrees per radian; one value; D]
inline constexpr double degrees_per_radian = 180 / std::numbers::pi;

// Planes whose normals have this cosine or more lean by 30 degrees at most; cos 30 itself is 0.86603.
// [cosine of the angle; 0 to 1; D]
inline constexpr double cos_of_about_30_degrees = 0.866;

// A vertex nearer to a segment than this share of its length lies on it: points that split it are rounded. [lengths of the segment; 0 to 1e-3; C clause 1]
inline constexpr double on_segment_share = 1e-6;

// Planes that move no point by more than the digits of a file are parallel exactly, or one. [mm; 0 to 0.01; D digits of
// files]
inline constexpr double exactly_parallel_mm = 1e-6;

}  // namespace anatomesh
