// cull: which region every cell of the Delaunay mesh belongs to; those outside every structure are culled.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/field/structure_field.h"
#include "anatomesh/mesh/region_registry.h"

namespace anatomesh {

struct CullStats {
    std::uint64_t decided = 0;  // cells
    std::uint64_t culled = 0;   // of these: outside
};

// Marks a vertex that lies on an interface.
inline constexpr Region on_interface = 0xFFFE;

// The region of every point from sides.size() on, or on_interface for one within `tolerance` mm of an interface;
// appended to `sides`. Same result at any thread count. Complexity: a few field values a point.
void find_sides(const std::vector<Vec3>& points, const StructureField& field, std::uint32_t structures, double tolerance,
                std::vector<Region>& sides, RegionRegistry& registry, RunContext& context);

// Decides the regions of the cells with the indices `chosen`, each in this order:
// 1. if the vertices off the interfaces all lie in one region, and no vertex lies on an interface, or at
// least one of
//    five points in the cell (its centroid and the four points half-way from there to the vertices) lies in
//    it: that region;
// 2. else the region that weighs most, by distance to the interface, among the five points; of a single
// structure that
//    of the centroid alone where no vertices name a region and it is a quarter of its mean distance from them
//    away from the interfaces.
// Rule 1 keeps the surface on vertices that lie on it. The decision of the 2006 method - a cell stays if ten
// points on its edges and facets are inside - asks the same field, but loses shells thinner than a cell, all
// of whose vertices lie on contours; rule 2 keeps them. Same result at any thread count. Complexity: at most
// five field values a cell. Follows: Archip et al., Comput. Methods Programs Biomed. 82, 2006, section 2.4
// (culling).
CullStats cull(const std::vector<Vec3>& points, const std::vector<Cell>& cells, std::span<const std::uint32_t> chosen,
               const std::vector<Region>& sides, const StructureField& field, std::uint32_t structures,
               std::vector<Region>& regions, RegionRegistry& registry, RunContext& context);

}  // namespace anatomesh
