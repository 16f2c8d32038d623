// small_handles: handles of a surface that are too small for its contours to tell of.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"
#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

// A part of a surface with handles, no point of which is far from others of it.
struct SmallHandles {
    std::uint32_t handles = 0;
    std::uint32_t middle = 0;             // a vertex of it
    std::vector<std::uint32_t> vertices;  // of it all, ascending
    friend bool operator==(const SmallHandles&, const SmallHandles&) = default;
};

// A handle is small where both ways round it, along it and about it, lie within `reach_mm` of one vertex
// along the edges: of about an edge length it is the mesh's own, and no drawing of planes further apart tells
// of it. Parts that touch are one. `triangles`: a closed oriented 2-manifold of `points`. By lowest triangle.
// Requires: reach_mm > 0. Complexity: O(n k log k) for n triangles, k of which lie within reach of a vertex.
// The genus of a disc-like part is had from its Euler number, as the surface's is: V - E + F = 2 - 2 g - b
// for b rims (classification of surfaces).
std::vector<SmallHandles> small_handles(std::span<const Vec3> points, std::span<const Triangle> triangles,
                                        double reach_mm);

}  // namespace anatomesh
