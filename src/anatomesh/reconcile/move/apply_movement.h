// apply_movement: contours move by a displacement of each node of their graph, as far as they stay sound.
#pragma once

#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/reconcile/move/original_positions.h"

namespace anatomesh {

// Moves every point of the set by the move of its node, which is given in the frame of the node's slice. A
// point that would come further than `most_mm` from where it was drawn stops at that distance. Where
// contours of a slice would cross, touch or lie otherwise in each other, the moves of the points around
// that place are halved, again and again. A slice that is never sound stays as it is.
//
// Requires: a kept contour set, its graph and its original positions, one move a node, most_mm > 0, and no
// point further than that from where it was drawn. Guarantees: a kept contour set, by exact predicates. No
// point is further than `most_mm` from where it was drawn, as rounded. Points that contours of a slice
// share stay shared, and a point whose move is zero keeps its bits. The result is the same at any number
// of threads. Complexity: O(n log n) a check of a slice, at most 16 checks each. No earlier method is
// followed.
void apply_movement(ContourSet& set, const ContourGraph& graph, const OriginalPositions& drawn,
                    const std::vector<Vec2>& moves, double most_mm, int threads);

}  // namespace anatomesh
