// AreaChange: what simplification does to the areas of structures.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// One contour before and after: its area in mm^2, negative for a hole, and the difference.
struct AreaChange {
    std::uint32_t structure = 0;
    double area_mm2 = 0;
    double change_mm2 = 0;  // >= 0
};

// Requires: both polygons in a plane with this normal. O(n).
AreaChange area_change(std::uint32_t structure, std::span<const Vec3> before, std::span<const Vec3> after,
                       Vec3 normal);

// Returns the area within a polygon in a plane with this normal, positive if counter-clockwise. O(n).
double area_in_plane(std::span<const Vec3> polygon, Vec3 normal);

// Adds up the changes of each structure and warns (W-CON-024) where they are more than 5 % of its area.
void warn_of_area_changes(std::span<const AreaChange> changes, const std::vector<Structure>& structures,
                          const std::string& source, RunContext& context);

}  // namespace anatomesh
