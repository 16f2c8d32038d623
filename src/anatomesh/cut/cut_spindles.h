// cut_spindles: non-manifold edges made manifold, a spindle of cells cut out of the cells round each.
#pragma once

#include <cstdint>

#include "anatomesh/cut/nonmanifold_patch.h"

namespace anatomesh {

// The second of the three moves of resolve_nonmanifold(), at every non-manifold edge whose ring of cells shares none
// with one before it. `reach`: how far a spindle reaches from its edge's middle towards its ring. (0, 1). Returns how
// many edges were split.
std::uint64_t cut_spindles(NonmanifoldPatch& patch, const PatchStars& stars, double reach,
                           PatchChange& change);

}  // namespace anatomesh
