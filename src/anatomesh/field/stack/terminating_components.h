// Parts of a drawn region that end between their slice and the next one while the rest of the region goes on.
#pragma once

#include <vector>

#include "anatomesh/field/slice/distance_map.h"

namespace anatomesh {

// A piece of a region (an outline with all that is drawn within it), or of what the region leaves free (a
// hole with all that is drawn within it: is_void). The edges bound it, the part on their left.
struct TerminatingComponent {
    std::vector<Edge2> edges;
    bool is_void = false;
    bool is_sure = true;  // that it ends; else it may
};

// The parts of the region `here` that have no counterpart in the region `there`, on the neighbouring slice:
// pieces that share no point with it and holes that lie in it wholly, and less than half of whose outline is,
// of all outlines here, the nearest to the outline there that is nearest to it and faces the same way (what
// leans moves instead). Besides, not sure, of what has nothing drawn within it: those of whose outline less
// than half is left so where a hole and an outline do not match across half of it; and holes that the region
// covers by more than half of their area, with no hole there that begins in them. Requires: gap > 0, the
// distance of the slices, mm. Complexity: linear in the edges where nothing is alone, else O(n log n + k n)
// for k such parts and holes.
std::vector<TerminatingComponent> terminating_components(const DistanceMap& here, const DistanceMap& there,
                                                         double gap);

// The outlines of a structure of a partition that end between `here` and `there` (null: where it is not drawn
// at all), touch others, and less than half of whose area lies in the union of all, `all_there`: part of an
// outline of the union, `all_here`, that goes on without them. Complexity: as terminating_components(), and
// O(n log n) where there are any.
std::vector<TerminatingComponent> terminating_components_of_union(const DistanceMap& here,
                                                                  const DistanceMap* there,
                                                                  const DistanceMap& all_here,
                                                                  const DistanceMap& all_there, double gap);

}  // namespace anatomesh
