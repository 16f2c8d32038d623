// warn_about_sparse_planes: structures much of which lies far from any plane they are drawn on.
#pragma once

#include <span>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

// W-FLD-008 for every structure of which more than a tenth of the volume inside `field` lies further from the
// slices that draw it, around their contours, than a quarter of its drawn thickness (twice the area over the
// length of its contours, the radius of a ball) and than `known_mm`: there the field fills in what nobody
// drew. `known_mm`, by structure: how far from a slice the field follows from those on both sides, as within a stack. Three
// planes at right angles through a ball leave 22 % so, n planes through its axis 20 % for n = 3, 8 % for 4,
// 2 % for 5. And for one on six planes or fewer, within 45 degrees of each other, whose
// volume is less than two fifths of that of a body as thick across them as in them (4/3 of a section's area
// times its thickness, of the largest): two planes through a ball at 5 to 30 degrees leave 5 to 29 % of it.
// Counted on a lattice of 16^3 points over the contours' box. Complexity: O(points + structures * (contours +
// slices)) with that factor; the field is asked only where a lattice point is that far off.
void warn_about_sparse_planes(const ContourSet& set, const StructureField& field,
                              std::span<const double> known_mm, RunContext& context);

}  // namespace anatomesh
