// give_overlaps: where structures overlap, the one that comes first in an order keeps the common part.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// What a structure lost to others, over all slices.
struct GivenOverlap {
    double area_mm2 = 0;       // of its drawn regions
    std::uint32_t slices = 0;  // on which it gave something
    bool all = false;          // nothing is left of it
};

struct PriorityResult {
    ContourSet kept;
    std::vector<GivenOverlap> given;   // per structure of the set
    std::vector<std::uint32_t> order;  // of all of them
};

// Makes the structures exclude each other on every slice, and keeps what was drawn beside that
// (`overlapping`) where structures lie in each other. The rules are these.
//
//  1. On every slice a structure keeps what of its region is outside those that come before it in the order.
//  2. Structures that `order` does not name come after all others. Of these, those drawn smaller on their
//     slices, in the mean, come first, and alike ones by index. So what is drawn in a body's outline stays
//     when the body is not named, and a thin structure stays whole.
//  3. A structure *lies in* a larger one that comes after it if half of its area or more is in it. So a
//     chamber lies in its wall, and a tumour in its organ. Then what was drawn stays beside, by levels of
//     nesting. Of two outlines that move from slice to slice each tells where it goes; what is left between
//     them may not meet itself again on the next slice.
//  4. Of the outline of what lies in another one, 10 % at most may run along the other's. Where more does,
//     both surfaces would be one there, and what is between them spurious components.
//  5. No structure may give more than 2 % of its area to one of another level that does not lie in it. What
//     was drawn is not kept beside where one does: what is left would be a small difference of large volumes.
//  6. For rules 3 and 4 a structure's whole drawing counts, or the slices alone that draw both. The latter
//     hold only if it is on all of the other one's slices between its own first and last, as a lesion drawn
//     more finely than its organ is. They hold for no structure as soon as two of one level have anything in
//     common, unless these two have slices of their own together (covering_slices.h). Where no slice draws
//     both, each contour is compared with the other one's next slices.
//  7. Where slices are not parallel, all structures must lie one in another: those that lie side by side are
//     interpolated between slices otherwise than one alone.
//
// Requires: a kept contour set; indices of `order` below its structures, none twice. Guarantees: a kept
// contour set, of the same slices, whose structures exclude each other (`exclusive` is set). Drawn vertices
// that still bound something keep their coordinates, and where contours crossed both have the crossing as a
// vertex. Loops narrower than 1e-3 mm that only crossings made are left out. A structure of which nothing is
// left is left out and warned about (W-PRI-001). Errors: geometry E-PRI-001 contours that cross too often,
// and those of clean_contours. Complexity: O((n + k) log n) a slice, k crossings.
Result<PriorityResult> give_overlaps(const ContourSet& set, const std::vector<std::uint32_t>& order,
                                     RunContext& context);

}  // namespace anatomesh
