// line_crossing: where two segments that meet do so, as a point.
#pragma once

#include <algorithm>

#include "anatomesh/geom/polygon.h"

namespace anatomesh {

// Returns the point of ab at which it meets cd: an end of cd on ab, or the rounded crossing; of several points the
// one nearest to a. Requires: the segments meet (segment_contact). O(1).
inline Vec2 line_crossing(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    if (on_segment(c, d, a)) return a;
    const bool has_c = on_segment(a, b, c), has_d = on_segment(a, b, d);
    if (has_c && has_d) return length(c - a) < length(d - a) ? c : d;
    if (has_c) return c;
    if (has_d) return d;
    if (on_segment(c, d, b)) return b;
    const double turn = cross(b - a, d - c);
    const double t = turn == 0 ? 0.5 : cross(c - a, d - c) / turn;
    return a + std::clamp(t, 0.0, 1.0) * (b - a);
}

}  // namespace anatomesh
