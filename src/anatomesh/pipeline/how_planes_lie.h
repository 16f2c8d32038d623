// how_planes_lie: how near to each other the planes of a set come, which decides what a run of the method
// does.
#pragma once

#include <cstdint>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

struct HowPlanesLie {
    double density = 0;    // plane_density()
    bool apart = false;    // they do not cross where something is drawn
    bool dense = false;    // closer than two thirds of the spacing of the contours' vertices
    bool crammed = false;  // so close, or so many, that all that can be done would take several times as long
    bool bear_all = false;     // missing subsegments may be brought back between them
    bool may_conform = false;  // that, they cross, and segments may be split for each other's sake
    bool meet_cuts = false;    // that, and cells are made what is drawn in them
};

// `spare_dense_above`: points of contours, times the square of the density; of dense planes with more all
// that can be done is too much. Requires: a kept contour set, its arrangement and its field. O(points)
HowPlanesLie how_planes_lie(const ContourSet& contours, const SliceArrangement& arrangement,
                            const StructureField& field, std::uint64_t spare_dense_above);

}  // namespace anatomesh
