// detach_facets_from_plane: no facet of a structure's surface stays in a slice's plane beside what is drawn
// there.
#pragma once

#include <cstdint>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

struct DetachmentStats {
    std::uint64_t facets_detached = 0, facets_left = 0;  // the latter for the sake of the cells' shapes
    std::vector<std::uint32_t> changed;                  // cells that were made; some may be gone again
};

// A cell in a structure that rests with a facet on the plane of a slice, between contour vertices and outside
// what is drawn of that structure, makes the model's cut larger than the drawing, although its surface is as
// good as where it belongs: where a structure widens from one slice to the next it starts in the plane
// itself. Such a cell is taken out, with those behind it where that makes better cells, and the hole is
// filled from a new vertex over the facet; the cell on the facet goes to the region across. Only where that
// region is the one drawn there: the surface stays a manifold, with the facet's edges on it. Two side by side
// are detached together if they can be and the edge between them is not in `fixed_edges`. A facet stays where
// cells inside would get an angle below `least_sine` or a ratio above the edit context's bound, and above
// what was there. Guarantees: no vertex moves, all cells positive (checked exactly). Complexity: O(cells).
// Errors: none.
DetachmentStats detach_facets_from_plane(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                         int threads);

}  // namespace anatomesh
