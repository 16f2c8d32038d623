// improve_dihedrals: raises the smallest dihedral angles of the cells inside, by local hill-climbing.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/improve/core/dihedral_options.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

// Takes the cells inside (of a region other than 0) with a dihedral angle below the target, worst first, and
// tries on each in turn: edge removal and facet removal (2-3, 3-2, 4-4 and general), moving its vertices,
// giving it to the other side of an interface, collapsing its edges, inserting a vertex. What makes the least
// sine of the dihedral angles of all cells concerned larger is done, nothing else. What is left at the end is
// tried again with new vertices on edges and facets of interfaces too, then, where an angle is below 10
// degrees and gets above it, with `last_radius_edge`; there vertices where three or more regions meet may
// move too, by `max_deviation_mm` at most in each step. Cells with a ratio above `last_radius_edge` are
// changed where that becomes lower by a tenth, at no angle below 10 degrees and below what it was; then those
// above the bound likewise, at none below the target (and 10 degrees) and below what it was. Before and
// after, spikes and pits of one cell are taken off the surfaces where the field has none, before that deep
// ones of any number are removed (remove_spikes.h); before and at last subsegments beside their surface are
// recovered to lie on it (recover_on_surface.h), until when they stay edges of the mesh; at last each chain
// of them may cost one cell in 100,000 above `max_radius_edge`, and contours of `drawn.routable` are
// re-routed along the surface where that does not help (reroute_on_section.h). In between, edges of surfaces
// are flipped for smaller angles between facets (flip_surface_edges.h), where no angle inside falls below the
// target or what it was. Near the end single cells below 10 degrees or above `last_radius_edge` beside those
// of `drawn.constraint_limited` are repaired at the price of these. Guarantees: no cell inside with an angle
// below the least before and below 10 degrees, but for those constraint-limited: these may come down to the
// bounds of quality_gate.h; all cells positive by exact orientation; vertices with fixed[v] != 0 do not move
// and stay on their surfaces, but for those of structures further away than `spike_mm`; `fixed_edges`
// (sorted, ends fixed) that lie on an interface stay edges of it, or chains of edges on the same line, whose
// new vertices are fixed as well; the surfaces of all structures keep their topology: each operation replaces
// a disc of a surface by a disc, but where a slice's plane has a handle, a tunnel or a neck that the slice
// has not (repair_section_patch.h), and where small handles are closed near the end. No ratio above the
// bound (at last the other one) arises but in the place of one as large, or of a constraint-limited cell.
// Cells outside serve as room; they stay positive, and none gets nearly flat but in the place of one as flat,
// or of a constraint-limited one. Same result every time. `fixed` grows with the points. Cells keep no order.
// Points no longer used stay in the list. `neighbors` are those of the mesh before and after, as
// cell_neighbors() gives them. Requires: the mesh holds the cells outside too, and every vertex on its hull
// is fixed. Complexity: linear in the cells, and in the operations tried for the bad ones. Follows: Klingner
// and Shewchuk, Proc. 16th International Meshing Roundtable, 2007; Freitag and Ollivier-Gooch, Int. J. Numer.
// Methods Eng. 40, 1997.
DihedralStats improve_dihedrals(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                std::vector<std::uint8_t>& fixed, std::span<const VertexPair> fixed_edges,
                                const StructureField& field, std::uint32_t structures,
                                const DrawnSlices& drawn, const DihedralOptions& options,
                                RunContext& context);

}  // namespace anatomesh
