// The ranges of the options that tools of the hand have in common.
#pragma once

namespace anatomesh {

inline constexpr double least_tolerance_mm = 1e-3;  // The least tolerance of a line. [mm; > 0; C]
inline constexpr double most_tolerance_mm = 10;     // The largest one. [mm; > least_tolerance_mm; C]
inline constexpr double least_radius_mm = 0.01;     // The least radius of a disc. [mm; > 0; C]
inline constexpr double most_radius_mm = 1000;      // The largest one. [mm; > least_radius_mm; C]
inline constexpr double least_pixel_mm = 1e-3;      // The least pixel of a picture. [mm; > 0; C]
inline constexpr double most_pixel_mm = 100;        // The largest one. [mm; > least_pixel_mm; C]
inline constexpr double most_reach_mm = 1000;       // A stroke is joined from no farther. [mm; > 0; C]

}  // namespace anatomesh
