// cull: which region every cell of the Delaunay mesh belongs to; those outside every structure are culled.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/field/structure_field.h"
#include "anatomesh/mesh/region_registry.h"

namespace anatomesh {

struct CullStats {
    std::uint64_t decided = 0;  // cells decided by this call
    std::uint64_t culled = 0;   // of all cells: outside
};

// Decides the region of every cell whose entry in `regions` is `undecided_region`. A cell far from every interface
// takes the region of its centroid; another one the region that weighs most, by distance to the interface, among
// its centroid and four points half-way from there to the vertices.
// The decision of the 2006 method - a cell stays if ten points on its edges and facets are inside - asks the same
// field, but loses shells thinner than a cell, whose cells have every vertex on a contour and some of the ten
// points outside; a weighed majority keeps them.
// Same result at any thread count. Complexity: five field values a cell.
// Follows: Archip et al., Comput. Methods Programs Biomed. 82, 2006, section 2.4 (culling).
inline constexpr Region undecided_region = 0xFFFF;

CullStats cull(const std::vector<Vec3>& points, const std::vector<Cell>& cells, const StructureField& field,
               std::uint32_t structures, std::vector<Region>& regions, RegionRegistry& registry, RunContext& context);

}  // namespace anatomesh
