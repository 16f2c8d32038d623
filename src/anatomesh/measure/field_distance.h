// How far the surfaces of a model are from those of the field that it was made of.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/base/structure.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// The largest distance of a vertex of a structure's surface, or of the middle of one of its facets, from that
// structure's surface in the field, which is at p - origin that of the model at p. Where structures exclude
// each other the surface of them all together is one more. A spike has a vertex far off; so has a spurious
// component, and a cavity where the field has none. A facet with several structures on one side that has none
// of them on the other lies on several surfaces: where the field has these apart, what is between them has a
// hole (`joined_mm`: the distance of all three vertices and the middle). Middles of all facets are measured
// up to a hundred thousand facets, of every second up to two hundred thousand, and so on. The field's value
// tells which thousand points to look round: where regions end between slices, and on a slice, it is more
// than the distance, which is the smallest in one of 26 directions, in steps of an eighth, at which the side
// differs or the surface is near by the value there. Of structures that exclude each other twice the value is
// looked at: half of what parts their own distances is their wall's. Distances near the field's clamp are
// said to be at least so large. `neighbors`: as cell_neighbors() gives them. `of_field`: the field's
// structure of each of `structures`, or no_cell: such a one is as if it were not there. Complexity: a query
// for each point and surface.
FieldDistanceReport farthest_from_field(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                        const RegionTable& regions, std::span<const Structure> structures,
                                        std::span<const std::uint32_t> of_field, const StructureField& field,
                                        Vec3 origin, int threads);

}  // namespace anatomesh
