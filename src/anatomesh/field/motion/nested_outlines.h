// Outlines of two neighbouring slices one of which lies well within the other: a part that is about to end.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/field/motion/boundary_pieces.h"

namespace anatomesh {

// The outline (or hole) of the neighbouring slice that one corresponds to, no_piece if there is none, and how
// far their pieces may lie from each other, mm.
struct NestedOutline {
    std::uint32_t other = no_piece;
    double reach = 0;
};

// For every outline of two boundaries `gap` (mm) apart. Two correspond if one lies within the other, no third
// of their kind (outlines or holes) is in it or round the inner one, and the radii of discs of their areas
// differ by 3.1 gaps or more, too far for pieces to find each other by themselves. A piece then moves by up
// to twice that difference. Complexity: linear in the pieces, quadratic in the outlines.
std::pair<std::vector<NestedOutline>, std::vector<NestedOutline>> nested_outlines(const Boundary& below,
                                                                                  const Boundary& above,
                                                                                  double gap);

}  // namespace anatomesh
