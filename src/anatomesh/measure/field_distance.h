// How far the surface of a model is from the interfaces of the field that it was made of.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/base/structure.h"
#include "anatomesh/field/structure_field.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/tet_mesh.h"

namespace anatomesh {

// The largest distance of a vertex of an interface, or of the middle of an interface's facet, from the
// nearest interface of the field, which is at p - origin that of the model at p. A spike has a vertex far
// off; so have a crumb, and a cavity where the field has none. Middles of all facets are measured up to a
// hundred thousand facets, of every second up to two hundred thousand, and so on. The field's value tells
// which thousand points to look round: where regions end between slices it is more than the distance, which
// is the smallest at which the region differs in one of 26 directions, in steps of an eighth. Distances near
// the field's clamp are said to be at least so large. `neighbors`: as cell_neighbors() gives them.
// Complexity: a query for each point.
FieldDistanceReport farthest_from_field(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                        const RegionTable& regions, std::span<const Structure> structures,
                                        const StructureField& field, Vec3 origin, int threads);

}  // namespace anatomesh
