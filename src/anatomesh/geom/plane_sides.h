// PlaneSides: planes of slices, and whether a point that moves stays on its side of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/parallel_planes.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

struct PlaneSides {
    ParallelPlanes stack;       // those that are parallel
    std::vector<Plane> planes;  // the others
    std::vector<Box2> extents;  // of each of the others, in its own frame; a plane ends there
    double on_plane_mm = 0;     // a point this near to a plane lies in it. >= 0

    // Whether a point that moves from one place to another passes through none of the planes, and leaves none that it
    // lies in. O(log planes) for the stack, O(planes) for others.
    bool keeps(Vec3 from, Vec3 to) const {
        if (!stack.heights.empty() && stack.level(from, on_plane_mm) != stack.level(to, on_plane_mm))
            return false;
        for (std::size_t k = 0; k < planes.size(); ++k) {
            const double before = planes[k].signed_distance(from), after = planes[k].signed_distance(to);
            if (side(before) == side(after)) continue;
            // The sides differ; a point that leaves a plane need not pass to its other side.
            const double share = std::clamp(before / (before - after), 0.0, 1.0);
            if (extents[k].contains(planes[k].to_plane(from + share * (to - from)))) return false;
        }
        return true;
    }

  private:
    int side(double height) const { return std::abs(height) <= on_plane_mm ? 0 : height > 0 ? 1 : -1; }
};

}  // namespace anatomesh
