#include "anatomesh/contour/resolve.h"

#include <cstddef>
#include <utility>

#include "anatomesh/contour/nesting.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

std::string nesting_rule(const std::vector<Ring>& rings, const Nesting& nesting, std::size_t r) {
    if (nesting.depth[r] == 0) return "outer";
    const std::string parent = std::to_string(rings[static_cast<std::size_t>(nesting.parent[r])].source);
    return nesting.depth[r] % 2 == 1 ? "hole of " + parent : "island in hole " + parent;
}

// Orients rings that keep apart by their depth, and says so where the source has no other reading yet.
Resolved finish(std::vector<Ring> rings, const RingEdges& edges, const CleanOptions& options) {
    const Nesting nesting = nest(edges, rings);
    Resolved resolved;
    for (std::size_t r = 0; r < rings.size(); ++r) {
        const bool filled = options.holes == HoleRule::united && nesting.depth[r] > 0;
        resolved.readings.push_back(
            {rings[r].source,
             filled ? "dropped: inside another, holes are filled" : nesting_rule(rings, nesting, r),
             filled ? 0 : static_cast<std::uint32_t>(rings[r].size()), 0, 0, false});
    }
    for (std::size_t r = 0; r < rings.size(); ++r) {
        if (options.holes == HoleRule::united && nesting.depth[r] > 0) continue;
        const bool counter_clockwise = signed_area(rings[r].at) > 0;
        if (counter_clockwise != (nesting.depth[r] % 2 == 0)) reverse_ring(rings[r]);
        resolved.rings.push_back(std::move(rings[r]));
        resolved.depth.push_back(nesting.depth[r]);
    }
    return resolved;
}

}  // namespace

Result<Resolved> resolve_rings(std::vector<Ring> rings, const Plane&, bool, const CleanOptions& options,
                               const PlaceOfSource& place_of) {
    const RingEdges edges(rings);
    if (!keep_apart(edges, rings)) {
        return Error{ErrorKind::geometry, "E-CON-006", "contours of one structure cross in one slice",
                     place_of(rings.front().source), "repair the contours"};
    }
    return finish(std::move(rings), edges, options);
}

}  // namespace anatomesh
