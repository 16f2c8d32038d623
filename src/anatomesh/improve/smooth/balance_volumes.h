// balance_volumes: the mesh encloses the volume that the field encloses.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/geom/plane_sides.h"
#include "anatomesh/improve/smooth/movable_mesh.h"

namespace anatomesh {

struct BalanceOptions {
    double max_radius_edge =
        contract::max_radius_edge;  // no ratio rises above both this and the worst at the vertex. [1.2, 10]
    double tolerance = 2e-4;        // relative difference of volumes that is left alone. [1e-9, 1]
    double max_offset_mm = 0.5;     // no vertex moves further than this. > 0
    int rounds = 12;                // [0, 100]
    double min_dihedral_degrees =
        15;                        // angles inside may fall to this; below it they do not get worse. [0, 40]
    PlaneSides slices;             // through which no vertex passes, and none that lies in one leaves it
    std::vector<Plane> ends;       // planes in which the surface is flat
    double end_tolerance_mm = 0;   // a facet whose vertices are this near to one of them lies in it. [0, 1]
    double max_difference = 1e-3;  // above it, with the ends held, they may move too. [1e-9, 1]
};

struct BalanceStats {
    std::uint64_t moves = 0;
    double largest_offset_mm = 0;              // of a vertex, in all
    double worst_before = 0, worst_after = 0;  // relative difference of a structure's volume
    bool ends_held = true;
};

// A surface whose vertices lie on a curved surface encloses less than it (flat facets cut the corners of a
// convex side). Here the free vertices of the interfaces are moved along their normals, all vertices of one
// interface by the same small offset, so that every structure's volume becomes `target_mm3`. Between two
// regions the offset is the difference of one number a structure, the least offsets in the mean square that
// meet the targets: the numbers solve a linear system, weighed by the areas that are free to move. Flat ends
// cut no corners: their vertices are put into their plane and move within it, and only where the volumes
// cannot be met like that the ends move as well (ends_held). No vertex passes through a slice's plane: what
// is cut there would be another area than is drawn. Guarantees: fixed vertices do not move;
// connectivity and regions do not change; every cell stays positive by exact orientation; the worst
// radius-edge ratio of the cells inside round a vertex never rises above both the bound and what it
// was; nor does the least sine of their dihedral angles fall below both that of the smallest angle allowed
// and what it was. A structure without free vertices keeps its volume. Requires: targets of all structures,
// in mm^3. Complexity: linear in the
// facets, a round. Same result at any number of threads.
BalanceStats balance_volumes(const MovableMesh& mesh, std::span<const double> target_mm3,
                             const BalanceOptions& options, int threads = 1);

}  // namespace anatomesh
