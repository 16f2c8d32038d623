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

// Where a structure widens from one slice to the next, its surface starts in the plane of the slice. A cell
// that rests there with a facet between contour vertices, outside what is drawn of the structure, makes the
// model's section too large. Such a cell is taken out, with those behind it where that makes better cells.
// The hole is filled from a new vertex over the facet, and the cell on the facet gets the region across.
//
// This is done only where that region is the one drawn there: the surface stays a manifold, with the facet's
// edges on it. Two facets side by side are detached together if they can be and the edge between them is not
// fixed. A facet stays where cells inside would get an angle below `least_sine`, or a ratio above the edit
// context's bound and above what was there. Guarantees: no vertex moves, all cells positive (checked
// exactly). Complexity: O(cells). Errors: none.
DetachmentStats detach_facets_from_plane(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                         int threads);

}  // namespace anatomesh
