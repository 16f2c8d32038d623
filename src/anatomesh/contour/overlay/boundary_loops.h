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

// Joins the edges to loops, each a list of indices into `edges` that visits no vertex twice. At a vertex where several
// meet, the loop bounds one wedge of the region. Loops begin in the order of `edges`. Requires: the edges bound a
// region, so as many come to each vertex as leave it; no edge comes twice; edges meet at vertices only.
// Complexity: O(n log n) for bounded degrees.
std::vector<std::vector<std::uint32_t>> boundary_loops(std::span<const Vec2> at,
                                                       std::span<const BoundaryEdge> edges);

}  // namespace anatomesh
