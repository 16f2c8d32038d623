// close_loops: a contour without the small loops that it makes by crossing itself, slips of the pen.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "anatomesh/contour/model/ring.h"
#include "anatomesh/contour/overlay/combine.h"

namespace anatomesh {

struct CloseLoopsOptions {
    double most_mm2 = 1;  // of a loop: smaller ones are closed. 0: none. [0, 100]
    // Of what the ring bounds, all of its loops together. [0, 1]
    double most_of_region = 2e-3;
};

struct ClosedLoops {
    Ring ring;  // simple: vertices of the ring as it was, and those at which it crossed itself
    std::uint32_t loops = 0;
    double area_mm2 = 0;               // of the loops
    std::uint32_t crossings = 0;       // vertices of the ring that were not drawn
    std::uint32_t points_dropped = 0;  // drawn ones that were of loops alone
};

// Nothing where the ring does not cross itself, or where more than one ring is left of it when all loops
// below the bounds are closed: then it stays as drawn. Nothing too where a vertex of `others` lies in the
// bounding box of a loop: what another contour draws in a loop, as a hole or an island, would become the
// other of the two. `rule` and `share`: as combine_rings() has them, by which what the ring bounds is found.
// Requires: three vertices or more, no zero-length edge; the ring itself may be among `others`, which are
// told apart by their source. Guarantees: the same whatever others do elsewhere. Complexity: that of
// combine_rings() for the ring, and O(loops x vertices of others).
std::optional<ClosedLoops> close_loops(const Ring& ring, std::span<const Ring> others, const Plane& plane,
                                       CombineRule rule, double share, const CloseLoopsOptions& options);

}  // namespace anatomesh
