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

// Returns the parts of the region `here` that have no counterpart in the region `there`, on the neighbouring slice.
// A piece ends if it shares no point with the region `there`, a hole if it lies in that region wholly. Both also need
// this: take the outline there that is nearest. Of all outlines here, this one is nearest to it, facing the same way,
// along less than half of its length. Otherwise the part leans and does not end.
// Parts that may end are returned as well, as not sure, if nothing is drawn within them. They are such pieces and holes
// that match along half of their length or more, but less without matches of a hole with an outline across more than
// half of the part. And they are holes of which the region covers half of the area or more, with no hole there that
// begins in them, and that match so along less than half.
// Requires: gap > 0, the distance of the slices, mm. Complexity: linear in the edges where nothing is alone, else
// O(n log n + k n) for k such parts and holes.
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
