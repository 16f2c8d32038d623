// cut_corners: vertices in which a body's surface makes several discs, made manifold, the corners of their stars cut off.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/cut/nonmanifold_patch.h"

namespace anatomesh {

// What became of contour segments.
struct CutSubsegments {
    std::vector<std::uint32_t> vertices;  // points added on contour segments, with which they go on
    std::vector<std::array<std::uint32_t, 3>>
        subsegments;  // that these were cut into: two vertices, structure
};

// The third of the three moves of resolve_nonmanifold(), at every non-manifold vertex whose star shares no cell with one
// before it. `share`: where the edges at the vertex are cut, of their length. (0, 1). Appends to `segments` and returns
// how many vertices were split.
std::uint64_t cut_corners(NonmanifoldPatch& patch, PatchStars& stars, double share, PatchChange& change,
                          CutSubsegments& segments);

}  // namespace anatomesh
