// close_loops: a contour without the small loops that it makes by crossing itself, which are slips of the pen.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "anatomesh/contour/model/ring.h"
#include "anatomesh/contour/overlay/combine.h"

namespace anatomesh {

struct CloseLoopsOptions {
    double most_mm2 = 1;  // only loops smaller than this are closed. 0: none. [0, 100]
    // All loops of a ring together are at most this share of the area that it bounds. [0, 1]
    double most_of_region = 2e-3;
};

struct ClosedLoops {
    Ring ring;  // simple: vertices of the ring as it was, and those at which it crossed itself
    std::uint32_t loops = 0;
    double area_mm2 = 0;               // of the loops
    std::uint32_t crossings = 0;       // vertices of the ring that were not drawn
    std::uint32_t points_dropped = 0;  // drawn ones that were of loops alone
};

// Returns nothing where the ring stays as drawn. This is so where it does not cross itself, and where more than one ring
// is left when all loops below the bounds are closed. It is also so where a vertex of `others` lies in the bounding box
// of a loop: a hole drawn there would become an island, or an island a hole. `rule` and `share` are those
// of combine_rings(), which finds what the ring bounds. Requires: three vertices or more, no zero-length edge. The ring
// itself may be among `others`; its source identifies it. Guarantees: the result is the same whatever others do
// elsewhere. Complexity: that of combine_rings() for the ring, and O(loops x vertices of others).
std::optional<ClosedLoops> close_loops(const Ring& ring, std::span<const Ring> others, const Plane& plane,
                                       CombineRule rule, double share, const CloseLoopsOptions& options);

}  // namespace anatomesh
