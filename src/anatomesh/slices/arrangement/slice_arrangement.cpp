#include "anatomesh/slices/arrangement/slice_arrangement.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "anatomesh/slices/arrangement/parallel_slices.h"

namespace anatomesh {

namespace {

// Three planes or more run through an axis where none of them leaves it by more than this between the ends of what is
// drawn: one that bends as it likes has no axis so exact. [diagonals of the box; 0 to 0.01; C]
constexpr double most_off_axis = 1e-3;

bool runs_through(const ContourSet& set, const Axis& axis) {
    const Box3 box = set.box();
    std::size_t drawn = 0;
    for (const Slice& slice : set.slices) {
        if (slice.contour_count == 0) continue;
        ++drawn;
        for (const double along : {-0.5, 0.5}) {
            const Vec3 at = axis.origin + along * box.diagonal() * axis.direction;
            if (std::abs(slice.plane.signed_distance(at)) > most_off_axis * box.diagonal()) return false;
        }
    }
    return drawn > 2;
}

}  // namespace

SliceArrangement arrangement_of(const ContourSet& set, double max_gap) {
    SliceArrangement made;
    if (is_parallel(set)) return made;
    made.kind = ArrangementKind::general;
    if (set.contours.empty()) return made;
    made.axis = rotation_axis(set);
    made.rotation = RotationalSweep::of(set, made.axis, max_gap);
    made.sweep = Sweep::of(set);
    if (made.sweep) {
        made.kind = ArrangementKind::sweep;
        return made;
    }
    // Where planes about an axis draw one side of it alone they follow a path too; ends turn about the axis there.
    const bool turns = made.rotation && runs_through(set, made.axis);
    if (auto paths = turns ? std::nullopt : paths_of_slices(set)) {
        made.paths = std::move(*paths);
        made.kind = ArrangementKind::along_paths;
        return made;
    }
    made.parts = stack_and_crossing(set);
    if (made.rotation)
        made.kind = ArrangementKind::about_axis;
    else if (made.parts)
        made.kind = ArrangementKind::stack_and_crossing;
    return made;
}

}  // namespace anatomesh
