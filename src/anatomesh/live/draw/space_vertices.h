// space_new_vertices: the vertices that a tool made get distances as those that were there.
#pragma once

#include "anatomesh/live/draw/area/structure_rings.h"

namespace anatomesh {

// Changes vertices of `after` that `before` does not have. One nearer than `least_mm` to a neighbour goes, where the
// triangle that it makes with its neighbours meets no other edge and holds no vertex. New edges longer than the longest
// edge before are split evenly. Requires: sound rings; `before` has one. Guarantees: sound rings.
// O(new vertices x vertices).
void space_new_vertices(const StructureRings& before, double least_mm, StructureRings& after);

}  // namespace anatomesh
