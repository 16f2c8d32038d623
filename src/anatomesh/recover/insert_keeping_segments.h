// insert_keeping_segments: vertices put into a mesh that is no Delaunay mesh any more, subsegments kept.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/sample/contour_segments.h"

namespace anatomesh {

// Puts each point into the mesh, in their order, if the cells that it makes are better than `least_shape`
// (cavity.h): into the cells whose circumspheres hold it (Bowyer and Watson), or else into the one that it
// lies in. `beside`: for each a vertex near it. `fixed`: by vertex, those that must stay besides the ends of
// subsegments. Returns the cells that are new, rising: in undecided_region. Guarantees: as
// recover_segments(). Complexity: O(cells) beside the insertions.
std::vector<std::uint32_t> insert_keeping_segments(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                                   std::span<const Vec3> points,
                                                   std::span<const std::uint32_t> beside,
                                                   const std::vector<Subsegment>& subsegments,
                                                   const std::vector<std::uint8_t>& fixed,
                                                   double least_shape);

}  // namespace anatomesh
