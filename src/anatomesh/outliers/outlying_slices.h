// find_outlying_slices: single slices that say something else than the slices on both sides of them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

enum class OutlierKind : std::uint8_t {
    displaced,       // the parts drawn there lie aside of the line between those on the slices beside
    larger,          // they take space that none of these has
    smaller,         // they lack space that both have
    other_shape,     // both
    part_missing,    // both have a part there
    part_alone,      // neither has a part near there
    part_displaced,  // both of these: a part lies elsewhere
    hole_missing,    // both have a hole there
    hole_alone,      // both are solid there
    hole_displaced   // both of these
};

struct OutlyingSlice {
    std::uint32_t slice = 0, structure = 0;
    OutlierKind kind = OutlierKind::displaced;
    Vec3 where;  // middle of the part or hole; of one that is missing, on the slice before
    double distance_mm =
        0;  // of what is displaced, how far; of parts alone, from the nearest part; else the mean
            // distance of the outline from where it may lie, or the width of the part or hole
    double area_mm2 = 0;                    // of what is too much and what lacks
    double share = 0;                       // that, of what is drawn there
    std::array<std::uint32_t, 2> beside{};  // the slices that it was compared with
};

// Each section of a structure is compared with those of the slices beside it (compare_sections.h), the slice itself left
// out (leave-one-out cross-validation: Stone, J. R. Stat. Soc. B 36, 1974). It is an outlier where all of this holds:
// - It leaves what lies between its neighbours by much: in area, and by its mean distance; or parts or holes are there
//   alone, or lack.
// - Its neighbours agree with each other better than with it.
// - Other slices of the structure, but for the two beside it, do not as much: by their median, and not one in ten does the
//   same half as much.
// The worst is taken out and the others are judged again without it, so that the slices beside a wrong one, and two that
// were exchanged, are judged by right ones. Where too many fall out nothing is said: then slices foretell each other badly.
// The first and the last section of a structure are not judged, because nothing tells how it ends, nor are those beside gaps.
// A slice is given for the structure that is worst there. Requires: a kept contour set; `arrangement` is that of the
// set. Returns them in order of slices, the same at any number of threads. Complexity: some thousand cells of a grid for
// each section, parallel over sections.
std::vector<OutlyingSlice> find_outlying_slices(const ContourSet& set, const SliceArrangement& arrangement,
                                                const RunContext& context);

}  // namespace anatomesh
