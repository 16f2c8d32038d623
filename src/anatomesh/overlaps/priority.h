// give_overlaps: where structures overlap, the one that comes first keeps what both have.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// What a structure had to give to others, over all slices.
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

// In every slice the region of a structure becomes what is left of it outside those that come before it in
// `order`; structures that `order` does not name come after all others, those drawn smaller on their slices,
// in the mean, first (what is drawn in a body's outline stays when that is not named; a thin one stays
// whole), alike ones by index. Requires: a kept contour set; indices of `order` below its structures, none
// twice. Guarantees: a kept contour set whose structures exclude each other (`exclusive` is set); all drawn
// vertices that still bound something keep their coordinates, and where contours crossed both have the
// crossing as a vertex; loops narrower than 1e-3 mm that only crossings made are left out. The slices are
// those of the set. Where a structure has half of its area or more in a larger one that comes after it, with
// an outline of its own (a chamber in its wall, a tumour in its organ), what was drawn stays beside
// (`overlapping`): of two outlines that move from slice to slice each tells where it goes, but what is
// between them may not meet itself again on the next slice. Of its outline 10 % may run along the other's:
// where more does, both surfaces would be one there, and what is between them spurious components; and no
// structure may give more than 2 % of its area to another one of these that does not lie in it. Its own
// slices alone count, those that draw both, where it is on all of the other one's between its own first and
// last (a lesion drawn more finely than its organ; where no slice draws both, which it lies in is told by the
// organ's next slices) and no structures of one level have anything in common, unless these have slices of
// their own together (covering_slices.h: neighbours drawn on the same ones). Where slices are not parallel
// all must lie one in another: what lies side by side is led between them otherwise than what is alone.
// Errors: geometry E-PRI-001 contours that cross too often, and those of clean_contours. A structure of which
// nothing is left is left out and warned about (W-PRI-001). Complexity: O((n + k) log n) a slice, k
// crossings.
Result<PriorityResult> give_overlaps(const ContourSet& set, const std::vector<std::uint32_t>& order,
                                     RunContext& context);

}  // namespace anatomesh
