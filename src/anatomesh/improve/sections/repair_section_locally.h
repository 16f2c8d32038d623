// repair_section_locally: the surfaces of structures pass through the planes of slices along what is drawn
// there alone.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

struct LocalRepairStats {
    std::uint64_t places_found = 0;  // facets that pass through a plane, or lie in it, where a cut is not
                                     // what is drawn
    std::uint64_t vertices_moved = 0, cells_relabelled = 0, edges_flipped = 0, edges_collapsed = 0,
                  vertices_inserted = 0;
    std::vector<std::uint32_t> changed;  // cells that were made or reshaped; some may be gone again
    std::vector<std::uint32_t> left;     // cells at facets that meet a plane still
};

// Where the contours are edges of the surface, three kinds of facets make the model's section another one
// than what is drawn: a facet of the surface that passes through a slice's plane, one that lies in it beside
// the drawn region, and one within a region that lies in it between contours. At each of them the first
// operation of section_operations.h is done that halves what is wrong in the sections of the cells
// concerned:
// 1. A free vertex is moved off the plane or across it.
// 2. A cell is relabelled to the region across the facet.
// 3. The edge of the surface across the plane is flipped.
// 4. A free vertex goes along such an edge onto its other end, which may move for the shapes of the cells
//    there.
// 5. The two cells at a facet in the plane are replaced by those of a new vertex beside it.
// 6. Where the section comes near to the 0.1 % that it may be wrong by, the surface leaves a free vertex
//    beyond the plane for a new one on this side of it.
// The two cells at a facet within a region are relabelled together to a region beside them.
//
// What was moved and what is new is fixed from then on for all others, and here when it was moved once more.
// Guarantees:
// - All cells are positive (checked exactly), and surfaces keep their topology and their contours.
// - Changed cells inside keep the edit context's target and bound. Where that is impossible and the section
//   comes near to 0.1 %, they have no angle whose sine is below `least_sine`, and no ratio above the last
//   bound, or than there was.
// - No moved vertex, collapsed edge or relabelled cell brings a surface further from the field's than the
//   edit context's `spike_mm`, or than it was. A new vertex stays within the cells at its facet, or within
//   `spike_mm`.
//
// `look`: the cells whose facets are looked at, in any order, repeats and such that are gone allowed; null:
// all. Same result every time. Complexity: O(cells), where planes are not parallel times their number, and
// its square at each facet that is wrong. After 10,000 places in vain the rest stays as it is, and of places
// that may cost worse cells after as many: where slices contradict each other, no surface can have all their
// sections. Errors: none; a cancelled run stops.
LocalRepairStats repair_section_locally(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                        const RunContext& context,
                                        const std::vector<std::uint32_t>* look = nullptr);

}  // namespace anatomesh
