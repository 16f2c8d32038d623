// find_undrawn_structures: structures that a slice leaves undrawn where slices that cross it show them.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// A slice without any contour of a structure that another one has on their common line.
struct UndrawnStructure {
    std::uint32_t slice = 0, structure = 0;
    std::uint32_t shown_by = 0;  // the slice that has most of it there
    double shown_mm = 0;         // along the line
};

// Where nothing of a structure is drawn on a slice, it was mostly not drawn rather than not there: the slice
// says nothing of it. One rule beside that: where slices that run within 30 degrees of it draw the structure
// on its one side only, and those that cross it lead the structure beyond it by `spacing` at most, or no more
// than half of those of other directions that draw it lead it so far at all, the slice lies beyond the
// structure's end and says "outside" - unless a slice of its direction nearer to the structure, beyond the
// same end, says nothing: what goes on through the nearer one is not ended by the farther. In order of slices
// and structures. `comparisons`: of the set (compare_planes). Complexity: O(points of comparisons' contours +
// slices^2), for each undrawn structure O(points of the slices with others of its structure).
std::vector<UndrawnStructure> find_undrawn_structures(const ContourSet& set,
                                                      std::span<const LineComparison> comparisons,
                                                      double spacing);

// The same of a whole set: `spacing` is that of its planes. Nothing where each slice draws all structures, or
// nothing at all. Complexity: that of compare_planes for the slices that leave something undrawn.
std::vector<UndrawnStructure> find_undrawn_structures(const ContourSet& set, RunContext& context);

// Whether a slice says nothing of a structure; `undrawn` in their order.
bool is_undrawn(std::span<const UndrawnStructure> undrawn, std::uint32_t slice, std::uint32_t structure);

}  // namespace anatomesh
