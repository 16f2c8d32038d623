// Prefetching: what a loop over a mesh reads a few steps later is brought into the cache meanwhile. The cells
// of a large mesh, and the points that they join, lie scattered in memory, where the hardware foresees
// nothing. Changes no result.
#pragma once

#include <cstddef>
#include <vector>

#include "anatomesh/geom/vec.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Loops over cells in the order of their numbers ask for the points of the cell so many later, so that memory
// answers in time. [cells; >= 1; B]
inline constexpr std::size_t cells_ahead = 8;

inline void prefetch_points(const std::vector<Vec3>& points, const Cell& cell) {
    for (const std::uint32_t v : cell) __builtin_prefetch(&points[v]);
}

}  // namespace anatomesh
