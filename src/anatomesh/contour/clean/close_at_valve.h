// close_at_valve: how a heart's chamber, drawn on a long axis up to its valve, is closed.
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

// What is drawn (a polyline nearly in a plane) is closed by a straight edge across the valve; where other
// contours of the structure pass its plane beyond that edge, no further than the valve is wide and beside it
// by no more than a quarter of that, by three edges round these: the edge was not drawn, and must not
// contradict what was. Nothing where the gap is more than half as long as what is drawn, which is no valve,
// or where it is none. `others`: closed contours of the structure; those that do not pass the plane do not
// matter. Requires: three points at least. O(points of all).
std::optional<ValveClosing> close_at_valve(std::span<const Vec3> drawn,
                                           std::span<const std::span<const Vec3>> others);

}  // namespace anatomesh
