// edges_along: the edges of a mesh that run along given segments.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/improve/core/drawn_slices.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// The mesh edges on interfaces that lie along the segments, as fixed_edges wants them: for each segment the
// chain of interface edges along the straight line that joins its ends; where there is none, the edges of
// those that start at its ends, and `missed`, if asked for, receives the segment. Requires: as
// region_facets(). Complexity: linear in the cells and the segments.
std::vector<VertexPair> edges_along(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                    std::span<const VertexPair> segments,
                                    std::vector<VertexPair>* missed = nullptr);

}  // namespace anatomesh
