// missing_pieces: which pieces of contour segments are not edges of the tetrahedralization.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/mesh/tet_mesh.h"
#include "anatomesh/sample/contour_segments.h"

namespace anatomesh {

// Indices of those pieces, whose ends are vertices of the cells, in rising order. A piece that is missing is split at its
// middle: the diametral balls of the halves are smaller, and hold no other vertex in the end (Shewchuk, Delaunay
// refinement mesh generation, 1997, chapter 4). Complexity: O(cells + pieces). Same result at any
// thread count.
std::vector<std::uint32_t> missing_pieces(const std::vector<Cell>& cells, std::size_t point_count,
                                          const std::vector<SegmentPiece>& pieces, int threads = 1);

}  // namespace anatomesh
