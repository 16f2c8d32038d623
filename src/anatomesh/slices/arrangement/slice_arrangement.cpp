#include "anatomesh/slices/arrangement/slice_arrangement.h"

#include <utility>

#include "anatomesh/slices/arrangement/parallel_slices.h"

namespace anatomesh {

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
    if (auto paths = paths_of_slices(set)) {
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
