// sliver_between: whether two stretches of contours that run against each other enclose a sliver, and how it is closed.
#pragma once

#include <optional>
#include <vector>

#include "anatomesh/contour/walls/conflated_contours.h"
#include "anatomesh/contour/walls/loop_stretches.h"
#include "anatomesh/contour/walls/slivers.h"

namespace anatomesh {

// Vertices that are to be put into loops.
using Insertions = std::vector<ConflatedContours::Beside>;

// Returns what closes the sliver between the stretches: the vertices of either that are put into the other, in one
// order for both. Returns nothing where it is none: it has more than three vertices of either, or one of them is not
// nearer to the other stretch than the width, or they are out of order along it. A sliver without vertices needs no
// insertions. Requires: the stretches run in opposite directions between the same two meetings.
// Complexity: O(vertices of both squared), which are few.
std::optional<Insertions> sliver_between(const LoopStretches& stretches, const Stretch& first,
                                         const Stretch& second, const CloseSliversOptions& options);

}  // namespace anatomesh
