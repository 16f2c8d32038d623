// join_lost_vertices: contour vertices that are off their structure's surface come to lie on it, cells relabelled.
#pragma once

#include <cstdint>

#include "anatomesh/cut/nonmanifold_patch.h"

namespace anatomesh {

// The first of the three moves of resolve_nonmanifold(). A vertex all of whose cells lie on one side of its structure
// is joined to the other side by the shortest path of cells; with none in the patch, the largest cell at it starts a
// component of that side. Returns how many were joined.
std::uint64_t join_lost_vertices(NonmanifoldPatch& patch, PatchStars& stars);

// Where no subdivision has room, beside a cell that is nearly flat: the smallest component too many of each
// vertex goes to the region round it. Returns how many did.
std::uint64_t relabel_components(NonmanifoldPatch& patch, PatchStars& stars);

}  // namespace anatomesh
