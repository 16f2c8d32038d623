// smooth_vertices: moves every free vertex to where the cells round it are best in the mean.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/plane_sides.h"
#include "anatomesh/improve/smooth/movable_mesh.h"

namespace anatomesh {

struct SmoothOptions {
    double max_radius_edge =
        contract::max_radius_edge;  // no ratio rises above both this and the worst at the vertex. [1.2, 10]
    double min_dihedral_degrees =
        16;  // nor does an angle (or 180 less it) fall below this and the least there. [0, 40]
    double tolerance_mm =
        0.05;  // vertices of an interface are put onto the field's to within a tenth of this. > 0
    double max_deviation_mm =
        0.1;            // of the middle of an interface facet from the field's, or as near as before. > 0
    PlaneSides slices;  // through which no vertex of an interface passes
    int passes = 1;     // each over the vertices beside which one moved in the last. [0, 100]
    double max_mean =
        HUGE_VAL;  // further passes, for smaller gains, while the mean ratio inside is above it. > 0
    int further_passes = 3;  // at most. [0, 100]
};

struct SmoothStats {
    std::uint64_t vertices_moved = 0, surface_vertices_moved = 0;  // once for every pass
};

// Gives each free vertex inside, and each on a smooth interface of two regions, the place near it where the
// sum of the radius-edge ratios of the cells inside round it is least: a few times down the gradient, or
// along the interface and then back onto that of the field between its regions. Vertices of more
// than 96 cells stay, and those where the sum hardly depends on the place; in the further passes it may
// depend on it less. Guarantees: fixed vertices do not move; connectivity and regions do not
// change; every cell stays positive by exact orientation, and none gets nearly flat; no facet of an interface
// turns by more than 37 degrees from what its surface was at the vertex. Same result at any number of
// threads. Complexity: linear in the cells.
// Follows: Freitag and Ollivier-Gooch, Int. J. Numer. Methods Eng. 40, 1997 (local optimisation, vertex by
// vertex).
SmoothStats smooth_vertices(const MovableMesh& mesh, const StructureField& field, std::uint32_t structures,
                            const SmoothOptions& options, RunContext& context);

}  // namespace anatomesh
