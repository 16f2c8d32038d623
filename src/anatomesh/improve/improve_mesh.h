// improve_mesh: raises the smallest dihedral angles of the cells inside by local hill climbing, lowers
// ratios, and repairs what single operations cannot.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/improve/core/drawn_slices.h"
#include "anatomesh/improve/core/edit_constraints.h"
#include "anatomesh/improve/core/mesh_improvement_options.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Cells inside (of a region other than 0) with a dihedral angle below the target are improved, the worst
// first. The hill climber tries local operations on each and makes those that raise the least sine of all
// cells concerned. The steps in their order (improve_mesh.cpp lists them; climb/climb_profile.cpp has the
// bounds of each pass):
//  - Subsegments beside their surface are kept as edges. Spikes and pits are removed from surfaces
//    (remove_spikes.h), and subsegments are recovered on their surface (recover_on_surface.h).
//  - Angles are raised to the target. Surface edges are flipped for smaller angles between facets
//    (flip_surface_edges.h), where no angle inside falls below the target or below what it was.
//  - Facets are detached from planes, and cross-sections are repaired locally.
//  - What is left is tried again with vertices on interfaces and moved junctions. An angle below 10 degrees is
//    worth a ratio up to `last_radius_edge`.
//  - Ratios above `last_radius_edge`, if few, and then those above the bound are lowered, each by a tenth at least.
//    Ill-shaped cells beside those of `drawn.constraint_limited` are repaired at the price of these.
//  - Subsegments are recovered again; each chain may cost one cell in 100,000 above the bound. Small handles and
//    wrong patches of sections are removed. Contours of `drawn.routable` are re-routed where nothing else helps.
//
// Guarantees:
//  - No cell inside gets an angle below 10 degrees and below the least before, but for constraint-limited cells:
//    these may come down to the bounds of quality_gate.h.
//  - No ratio above the bound (at last `last_radius_edge`) arises but in the place of one as large, or of a
//    constraint-limited cell.
//  - All cells are positive by exact orientation. Cells outside serve as room; none gets nearly flat but in the place
//    of one as flat, or of a constraint-limited one.
//  - Fixed vertices do not move. They stay on their surfaces, but for those of structures further away than
//    `least_spike_mm`. Fixed edges that lie on an interface stay edges of it or become chains on the same line.
//  - The surfaces of all structures keep their topology, but where a slice shows otherwise (repair_section_patch.h)
//    and where small handles are removed.
//  - The result is the same every time, and for any number of threads.
//
// The list `fixed` of the constraints grows with the points; new vertices on fixed edges are fixed. Cells
// keep no order, and points no longer used stay. `neighbors` are those of the mesh before and after, as
// cell_neighbors() gives them. Requires: the mesh holds the cells outside too, and every vertex on its hull
// is fixed. Complexity: linear in the cells, and in the operations tried on bad ones. Errors: none; a
// cancelled run stops early. Follows: Klingner and Shewchuk, Proc. 16th International Meshing Roundtable,
// 2007; Freitag and Ollivier-Gooch, Int. J. Numer. Methods Eng. 40, 1997.
MeshImprovementStats improve_mesh(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                  const EditConstraints& constraints, const StructureField& field,
                                  std::uint32_t structures, const DrawnSlices& drawn,
                                  const MeshImprovementOptions& options, RunContext& context);

}  // namespace anatomesh
