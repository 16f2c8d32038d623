// check_drawing: whether what an edit leaves is a drawing.
#pragma once

#include <string>

#include "anatomesh/live/edit/edit.h"

namespace anatomesh {

// Checks all that the edit touched in `drawing`, which is what it led to: planes, rings on them, structures, their order,
// pins, and what refers to what the edit removed. Errors: E-EDT-002 to -008, -010, -011, -013 (edit.h).
// Complexity: O(changes x planes) for changed planes, O(n) for removed ones; of changed rings O(points log points).
Status check_drawing(const Drawing& drawing, const Edit& edit, CrossingCheck crossings);

// Error: E-EDT-013 the name is no UTF-8, or longer than 1 MiB, which is what a contour file can hold.
Status check_name(const std::string& name, Place place);

// "(1, 2.5, -3)", with three digits, for messages.
std::string brief_point(Vec3 p);

}  // namespace anatomesh
