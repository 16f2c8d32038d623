// improve: moves free vertices so that the surface lies on the interface and the cells round them get better.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

struct ImproveOptions {
    double max_radius_edge = contract::max_radius_edge;  // cells inside above it are worked on. [1.2, 10]
    double tolerance_mm = 0.05;  // vertices of an interface within this of the field's are left there. > 0
    int rounds = 4;              // over the vertices of bad cells. [0, 100]
};

struct ImproveStats {
    std::uint64_t vertices_onto_interface = 0;                    // moved onto the interface of the field
    std::uint64_t vertices_smoothed = 0;                          // moved for the sake of their cells
    std::uint64_t above_bound_before = 0, above_bound_after = 0;  // cells inside
};

// Two passes. First every vertex of the mesh's surfaces that is off one of these in the field is moved
// towards it, as far as the cells round it allow (`regions`: the structures of each). Then every free vertex
// of a cell inside whose radius-edge ratio is above the bound is moved to where the worst ratio round it is
// least (compass search), on an interface within the tolerance. Guarantees: vertices with fixed[v] != 0 do
// not move; connectivity and regions do not change, so neither does the topology of any surface; every cell
// stays positive by exact orientation; no move makes the worst ratio of the cells inside round it worse,
// unless all of them stay below the bound. Requires: `stars` of the mesh, which holds the cells outside too,
// round every interface, so that no move can fold the outside. Complexity: linear in the vertices moved and
// their stars. Follows: Freitag and Ollivier-Gooch, Int. J. Numer. Methods Eng. 40, 1997 (optimisation-based
// smoothing).
ImproveStats improve(TetMesh& mesh, const VertexStars& stars, const std::vector<std::uint8_t>& fixed,
                     const StructureField& field, std::uint32_t structures, const RegionTable& regions,
                     const ImproveOptions& options, RunContext& context);

}  // namespace anatomesh
