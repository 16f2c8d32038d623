// close_at_valve: closes the contour of a heart's chamber, which on a long axis is drawn up to its valve.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

struct ValveClosing {
    double gap_mm = 0;          // between the ends of what is drawn
    double beyond_mm = 0;       // as far beyond them other contours of the structure go on
    std::vector<Vec3> between;  // to be put between the last point and the first; none: a straight edge
};

// What is drawn is a polyline nearly in a plane. It is closed by a straight edge across the valve, unless other
// contours of the structure pass its plane beyond that edge. Those count up to as far as the valve is wide, and up
// to a quarter of this beside it. Three edges then run round them, because the edge was not drawn and must not
// contradict what was. Returns nothing where there is no gap, or where the gap is more than half as long as what is
// drawn, which is no valve. `others` are the closed contours of the structure; those that do not pass the plane do
// not matter. Requires: three points or more. O(points of all).
std::optional<ValveClosing> close_at_valve(std::span<const Vec3> drawn,
                                           std::span<const std::span<const Vec3>> others);

}  // namespace anatomesh
