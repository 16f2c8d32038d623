// remove_spikes: spikes and pits of surfaces, of any number of cells, come down to where the field has the
// surface.
#pragma once

#include <cstdint>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// Spikes and pits of one cell: a cell with three facets on one surface, whose common vertex is free and off
// the field's interface, is relabelled to the region beyond, where the facet that comes to the surface in
// their place lies nearer to the field's interface. Goes on with the cells beside as long as there are such.
// A cell that comes inside must have at least this sine, and no ratio above the edit context's bound. Returns
// the number of cells. Guarantees: no vertex moves; surfaces keep their topology. O(cells)
std::uint64_t remove_cell_spikes(EditContext& edit, double least_sine, int threads);

struct SpikeStats {
    std::uint64_t found = 0, removed = 0;
};

// A surface may have a vertex deep inside a region: where a cell was relabelled to make the surface a
// manifold, or to have a contour segment on it, or where it reaches a contour vertex of another structure.
// Such an apex - the cells of one region at it cut a disc out of a small sphere round it, and every surface
// that bounds them there and not the region in which the field is is further off in the field than `spike_mm`
// - can't be moved down: these cells, which stand on contours, would get flat. Instead they let go of it: a
// new vertex, near their base or the field's surface, takes its place in them, and each facet of their surface at the apex makes a
// cell with the new vertex, in the region that the field is in. That is an isotopy of the surfaces between
// the two regions; others at the apex stay as they are, and so does the apex on them. Where several regions
// lie beyond the facets it is done only if the one that grows stays bounded by a disc at each vertex
// concerned. Done where the new vertex is nearer to the field's surface by a quarter and no facet further
// from it, and where cells inside have at least `least_sine` and no ratio above the edit context's bound, or,
// where that fails, its last one. Guarantees: no vertex moves; all cells positive (checked exactly).
// Complexity: O(cells), and the stars of the spikes.
SpikeStats remove_spikes(EditContext& edit, double spike_mm, double least_sine, int threads);

}  // namespace anatomesh
