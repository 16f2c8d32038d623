// refill_from_heights: cells are replaced by those of a new vertex beside a plane.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/improve/core/hole.h"

namespace anatomesh {

// What new cells inside must keep.
struct CellBounds {
    double sine;   // of the least angle
    double ratio;  // of circumradius and shortest edge, or the largest that there was
};

// Cells that go, and the line on which the new vertex may lie.
struct Refill {
    std::vector<std::uint32_t> cells;        // of one region
    std::span<const Hole::CellFacet> given;  // facets whose new cells get the region across (hole.h)
    Vec3 foot, top;                          // heights are shares of the way from the one to the other
};

// Starts from each height in turn, and moves the vertex to where the cells are best, as long as
// `may_lie(place)`. Returns the vertex from the first height whose cells keep the bounds, or no_cell: then
// the mesh is as it was. Complexity: O(heights x cells).
template <class MayLie>
std::uint32_t refill_from_heights(EditContext& edit, const Refill& refill, std::span<const double> heights,
                                  const CellBounds& bounds, const MayLie& may_lie) {
    const auto needed_sine = [&](const QualityThreshold&) { return bounds.sine; };
    for (const double height : heights) {
        const auto v = static_cast<std::uint32_t>(edit.mesh.point_count());
        if (Hole(edit, refill.cells, refill.given)
                .fill(refill.foot + height * (refill.top - refill.foot), {}, bounds.ratio, needed_sine,
                      may_lie))
            return v;
    }
    return no_cell;
}

}  // namespace anatomesh
