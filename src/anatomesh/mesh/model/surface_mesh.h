// SurfaceMesh: a triangle mesh as flat arrays.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/geom/vec.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

using Triangle = std::array<std::uint32_t, 3>;

// Facets between two different regions of a tetrahedral mesh, or any triangle surface that was read.
// Vertices run counter-clockwise seen from `outer`. inner > outer is not implied; outer may be 0 (outside).
struct SurfaceMesh {
    std::vector<Vec3> points;
    std::vector<Triangle> triangles;
    std::vector<std::array<Region, 2>>
        sides;  // per triangle {inner, outer}; empty for a surface without regions
};

}  // namespace anatomesh
