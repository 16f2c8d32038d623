// boundary_loops: the simple loops that bound a region of a plane graph.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// An edge between vertices of a plane graph, the region on its left.
struct BoundaryEdge {
    std::uint32_t from = 0, to = 0;
};

// The edges put together to loops, each a list of indices into `edges` that visits no vertex twice. At a
// vertex where several meet, the loop bounds one wedge of the region. Requires: the boundary of a region (at
// each vertex as many edges come as leave), no edge twice, edges that meet at vertices only. Deterministic:
// loops begin in the order of `edges`. Complexity: O(n log n) for bounded degrees.
std::vector<std::vector<std::uint32_t>> boundary_loops(std::span<const Vec2> at,
                                                       std::span<const BoundaryEdge> edges);

}  // namespace anatomesh
