// Chains: the contours of one slice as a planar network, and its simplification within a bound.
//
// A chain runs between two junctions (points where more than two boundary pieces meet, or where neighbours
// change) or is a closed loop. What two structures share is one chain, so it is simplified once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Chain c is the points chain_points[first[c], first[c + 1]); a loop repeats its first point at the end.
// Junctions are the first and last points of open chains; `has_junction[c]` says whether a loop holds one.
// A point lies inside at most one chain.
struct ChainNetwork {
    std::vector<Vec2> points;
    std::vector<std::uint32_t> chain_points;
    std::vector<std::uint32_t> first{0};
    std::vector<std::uint8_t> has_junction;

    std::size_t size() const { return first.size() - 1; }
    std::span<const std::uint32_t> chain(std::size_t c) const {
        return {chain_points.data() + first[c], first[c + 1] - first[c]};
    }
    // Ends the chain whose points were appended to chain_points.
    void close_chain(bool with_junction) {
        first.push_back(static_cast<std::uint32_t>(chain_points.size()));
        has_junction.push_back(with_junction ? 1 : 0);
    }
};

// All lengths are in the unit of the points.
struct ThinOptions {
    double epsilon = 0;  // every point stays within this of the kept segment that spans it. > 0
    double spacing = 0;  // kept points closer than this along a chain are avoided where epsilon allows. >= 0
    double clearance = 0;  // kept points nearer than this to a foreign segment are avoided where the traced
                           // chain keeps further away. >= 0
};

struct ThinResult {
    std::vector<std::uint8_t> kept;  // per point
    double max_distance = 0;         // of a point from the kept segment that spans it
};

// Requires: loops of at least three points; all coordinates finite.
// Guarantees: junctions are kept, and loops keep at least three points. The bound holds. Kept segments cross, touch or
// overlap only where the chains they stand for do. No kept point lies between a kept segment and the chain it stands for,
// so nesting and sides are unchanged.
// Method: dynamic programming over all shortcuts within the bound finds the polygon of least cost for each chain (Imai
// and Iri, Computational Morphology, 1988). Cones test the bound (Chan and Chin, ISAAC 1992). A vertex costs one, and segments that
// are short or much longer than the others cost more. Then segments that break a guarantee are split at their farthest
// point until none does (after Saalfeld, Cartography and GIS 26, 1999). Complexity: expected O(n k) with k the points
// under a shortcut, at most 128.
ThinResult thin_chains(const ChainNetwork& network, const ThinOptions& options);

}  // namespace anatomesh
