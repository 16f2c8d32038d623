// cull: which region every cell of the Delaunay mesh belongs to; those outside every structure are culled.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/mesh/model/region_registry.h"
#include "anatomesh/mesh/model/vertex_membership.h"

namespace anatomesh {

struct CullStats {
    std::uint64_t decided = 0;  // cells
    std::uint64_t culled = 0;   // of these: outside
};

// How near a surface passes that counts as passing through a point.
struct SurfaceTolerance {
    double mm = 0;       // > 0
    double of_edge = 0;  // and in shares of the point's shortest edge when its side is found; 0: any. [0, 1]
};

// The cells of a mesh that a call is about: all of them, or those that are new.
struct ChosenCells {
    const std::vector<Vec3>& points;
    const std::vector<Cell>& cells;
    std::span<const std::uint32_t> chosen;  // indices of cells, without repeats
};

// Finds the membership of every point from memberships.size() on and appends it to `memberships`; those before
// stay, whatever comes beside them. Requires: `mesh` has all cells at the new points among the chosen ones. Same
// result at any thread count. Complexity: a few field values a point; with `of_edge` also O(chosen), on one thread.
void find_memberships(const ChosenCells& mesh, const StructureField& field, std::uint32_t structures,
                      const SurfaceTolerance& tolerance, std::vector<VertexMembership>& memberships,
                      RegionRegistry& registry, RunContext& context);

// Decides the regions of the chosen cells, each in this order:
// 1. the region of all its vertices, if these are off the interfaces and lie in one;
// 2. of the regions at five points in the cell (its centroid and the four points half-way from there to the
//    vertices) that its vertices may all belong to, that which weighs most, by distance to the interface;
// 3. else the one that weighs most of all five; of a single structure that of the centroid alone where no
//    vertices name a region and it is a quarter of its mean distance from them away from the interfaces.
// Rules 1 and 2 keep the surface of every structure on vertices that lie on it. The decision of the 2006
// method - a cell stays if ten points on its edges and facets are inside - asks the same field, but loses
// shells thinner than a cell, all of whose vertices lie on contours; rules 2 and 3 keep them. Same result at
// any thread count. Complexity: at most five field values a cell. Follows: Archip et al., Comput. Methods
// Programs Biomed. 82, 2006, section 2.4 (culling).
CullStats cull(const ChosenCells& mesh, const std::vector<VertexMembership>& memberships,
               const StructureField& field, std::uint32_t structures, std::vector<Region>& regions,
               RegionRegistry& registry, RunContext& context);

}  // namespace anatomesh
