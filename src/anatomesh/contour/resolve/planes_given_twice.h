// A plane that a file gives twice: what is drawn on its twins is one drawing, two drawings of one outline, or a
// contradiction that only the user can decide.
#pragma once

#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/ring.h"
#include "anatomesh/contour/overlay/combine.h"
#include "anatomesh/contour/resolve/resolve.h"

namespace anatomesh {

// Whether the rings come from more than one declared plane. O(rings).
bool are_on_several_planes(const std::vector<Ring>& rings);

// Takes away every ring that bounds the region of its own plane where that of another plane goes on; what is
// left then bounds the union by nesting. Returns whether there was one. `combined` is of all the rings.
// Warns: W-CON-022. O(rings^2 log rings).
bool unite_nested_planes(std::vector<Ring>& rings, const Combined& combined, RingReadings& readings);

// Drops the first ring that nearly repeats a ring of another plane, and returns whether there was one. Warns:
// W-CON-018. Error: E-CON-007 two rings contradict each other, unless the options unite them. O(rings^2).
Result<bool> drop_repeat_of_plane(std::vector<Ring>& rings, const Combined& combined,
                                  const ResolveOptions& options, RingReadings& readings);

// A ring that lies inside a ring of the twin plane is as likely a second drawing of the outline as a hole.
// Warns: W-CON-022 where it changes nothing. Error: E-CON-007 where it would be a hole. O(rings).
Status check_nesting_across_planes(const std::vector<Ring>& rings, const Combined& combined,
                                   RingReadings& readings);

}  // namespace anatomesh
