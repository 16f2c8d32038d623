// Outlines of two neighbouring slices that are one shape, moved far: sections of an oblique tube.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/field/motion/boundary_pieces.h"
#include "anatomesh/field/slice/distance_map.h"

namespace anatomesh {

// The linear map that takes the centre and the second moments of one outline to those of another, without
// turning: optimal transport between ellipses of these moments (Dowson and Landau, J. Multivar. Anal. 12, 1982).
struct OutlineMap {
    std::uint32_t other = no_piece;  // the outline of the neighbouring slice; no_piece: none
    Vec2 from, to;                   // the centres
    double xx = 1, xy = 0, yy = 1;   // a symmetric matrix

    Vec2 operator()(Vec2 q) const {
        const Vec2 r = q - from;
        return to + Vec2{xx * r.x + xy * r.y, xy * r.x + yy * r.y};
    }
};

// By outline of the slice below, and of the one above. Both are empty where none is aligned.
struct AlignedOutlines {
    std::vector<OutlineMap> below, above;
    bool empty() const { return below.empty(); }
};

// A slice, and how well a motion takes its outlines to the neighbouring slice (amiss_shares()).
struct CarriedSlice {
    const Boundary& boundary;
    const DistanceMap& map;
    std::vector<double> amiss;
};

// By outline, how far its pieces lie from the boundary of the other slice where they are carried, times their
// length, as a share of its area: about the area carried amiss. `carried`: the middles of the pieces there.
std::vector<double> amiss_shares(const Boundary& boundary, const DistanceMap& other,
                                 std::span<const Vec2> carried);

// The pairs of outlines to align, `gap` (mm) apart. A pair is of one kind (outlines or holes) and close in
// shape after its map; it lies less far apart than a tenth more than where the two would touch; each is the
// nearest such one of the other; and no third outline without such a partner overlaps either, as where a tube
// branches. It is aligned if it moves by more than the usual search follows, and the motion found without
// carries it amiss, and its map much less. Complexity: linear in the pieces, quadratic in the outlines.
AlignedOutlines aligned_outlines(const CarriedSlice& below, const CarriedSlice& above, double gap);

}  // namespace anatomesh
