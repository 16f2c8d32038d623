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
#include "anatomesh/mesh/stars/star.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

using VertexPair = std::array<std::uint32_t, 2>;  // smaller vertex first

inline constexpr std::uint32_t no_slice = 0xFFFFFFFFu;

// All contours, which may leave where they are drawn for where the surface is (follow_surface.h).
struct FollowingContours {
    std::span<const Contour> contours = {};        // those of a slice and structure one after the other
    std::span<const std::uint32_t> vertices = {};  // of the mesh, of every point of theirs
    std::span<const Plane> planes = {};            // by slice
    bool exclusive = false;                        // structures, as in contour sets
    double most_mm = 0;                            // no further; 0: they stay. >= 0
};

// One that did.
struct FollowedContour {
    std::uint32_t contour = 0;            // its index
    std::vector<std::uint32_t> vertices;  // all, in order
    std::uint64_t segments = 0;           // drawn, missed before and not any more
    double farthest_mm = 0;               // of it from what was drawn, and of that from it
    friend bool operator==(const FollowedContour&, const FollowedContour&) = default;
};

// What is drawn on slices, for the facets in their planes.
struct DrawnSlices {
    const RegionTable* table = nullptr;       // of the mesh's regions
    std::span<const std::uint32_t> slice_of;  // for every point of the mesh the slice in whose plane it lies
                                              // as a part of a contour, or no_slice; empty: no slices
    const ContourOwners* owners = nullptr;    // of the vertices
    std::span<const Plane> planes = {};       // by slice, or empty: cuts are not looked at
    std::span<const Box2> extents = {};       // by slice, in its plane: beyond them it says nothing; empty:
                                              // planes are parallel, and each says all
    std::span<const double> weights = {};     // at structure * planes + slice: 1 / mm^2 drawn; 0 where the
                                              // slice does not tell where the structure is
    double on_plane_mm = 0;                   // a vertex this near to a plane lies in it. >= 0
    // Above 0: of cuts those alone are looked at, and at last, before contours are led, of which so large a
    // share of what is drawn is wrong then. Others beside them may get a little worse.
    double least_wrong = 0;
    // Pieces of contour segments, known to the owners, with cells on one side of their structure alone: two
    // vertices and the structure.
    std::span<const std::array<std::uint32_t, 3>> pieces_beside = {};
    std::span<const std::uint8_t> crowded =
        {};  // by vertex: contours force the shapes of its cells; or empty

    FollowingContours following = {};

    // Whether one of these vertices, of a cell or a facet, is.
    bool are_crowded(std::span<const std::uint32_t> vertices) const {
        return std::any_of(vertices.begin(), vertices.end(),
                           [&](std::uint32_t v) { return v < crowded.size() && crowded[v] != 0; });
    }
};

struct DihedralOptions {
    double target_degrees =
        15;  // cells inside with an angle below it (or above 180 less it) are worked on. [0, 40]
    double max_radius_edge =
        2.0;  // no operation makes a ratio above it that is also above what it was. [1.2, 10]
    double tolerance_mm =
        0.05;  // vertices of an interface stay within this of the field's, or as near as they were. > 0
    double max_deviation_mm =
        0.1;  // of the middle of a changed interface facet from the field's, or as near as before. > 0
    double last_deviation =
        2;  // the bound grows by this factor for the cells that are still bad after all passes. [1, 10]
    // Instead of max_radius_edge, at last, where that leaves an angle below 10 degrees; if larger, cells
    // above it are worked on too. >= 1.2
    double last_radius_edge = 3.9;
    double flip_gain_degrees = 2;  // edges of surfaces are flipped where that makes the angles at their
                                   // facets fall by more. (0, 900]
    double apex_mm = 1;    // a vertex of a surface further from the field's is lowered (lower_apexes.h). > 0
    int passes = 4;        // over the cells that are still bad. [0, 100]
    int ratio_passes = 4;  // over the cells above max_radius_edge, after those. [0, 100]
    // Handles of surfaces within so little along them are closed, where no contour of `drawn.following` tells
    // of them (close_handles.h); 0: none. >= 0
    double handle_mm = 0;
    // Whether cells between the bound and last_radius_edge may go to another side for their ratio, as those
    // above may: to the outside, it may leave pits.
    bool gives_for_ratio = false;
};

struct DihedralStats {
    std::uint64_t bad_before = 0, bad_after = 0;                 // cells inside below the target
    double worst_before_degrees = 90, worst_after_degrees = 90;  // by the least sine
    // Operations that were applied.
    std::uint64_t vertices_moved = 0, surface_vertices_moved = 0, edges_removed = 0, facets_removed = 0,
                  surface_edges_flipped = 0, surface_edges_smoothed = 0, cells_given = 0, ears_dropped = 0,
                  edges_collapsed = 0, vertices_inserted = 0, facets_lifted = 0, apexes_lowered = 0,
                  tries = 0;
    std::uint64_t cuts_found = 0, cuts_mended = 0;       // visits and changes (mend_cuts.h, carve_cuts.h)
    std::uint64_t crumbs_given = 0;                      // that came off where cuts were carved
    std::uint64_t handles_found = 0, handles_closed = 0;  // that no contour tells of
    std::uint64_t pieces_found = 0, pieces_brought = 0;  // of contour segments (bring_segments.h)
    std::uint64_t segments_missed = 0;                   // of drawn.following, before follow_surface()
    std::vector<FollowedContour> followed;
    std::uint64_t facets_left = 0;  // in slices, beside what is drawn there (lift_facets.h)
    std::uint64_t cells_made = 0;   // by all operations, those taken back included
};

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
// ones of any number are lowered (lower_apexes.h); before and at last contour pieces beside their surface are
// brought to lie on it (bring_segments.h), until when they stay edges of the mesh; at last each chain of them
// may cost one cell in 100,000 above `max_radius_edge`, and contours of `drawn.following` are led along the
// surface where that does not help (follow_surface.h). In between, edges of surfaces are flipped for smaller
// angles between facets (flip_surface_edges.h), where no angle inside falls below the target or what it was.
// Near the end single cells below 10 degrees or above `last_radius_edge` beside those of `drawn.crowded` are
// mended at the price of these. Guarantees: no cell inside with an angle below the least before and below 10
// degrees, but for those crowded: these may come down to the bounds of cell_judge.h; all cells positive
// by exact orientation; vertices with fixed[v] != 0 do not move and stay on their surfaces, but for those of
// structures further away than `apex_mm`; `fixed_edges` (sorted, ends fixed) that lie on an interface stay
// edges of it, or chains of edges on the same line, whose new vertices are fixed as well; the surfaces of all
// structures keep their topology: each operation replaces a disc of a surface by a disc, but where a slice's
// plane has a handle, a tunnel or a neck that the slice has not (carve_cuts.h), and where small handles are
// closed near the end. No ratio above the
// bound (at last the other one) arises but in the place of one as large, or of a crowded cell. Cells outside
// serve as room; they stay positive, and none gets nearly flat but in the place of one as flat, or of a
// crowded one. Same result every time. `fixed` grows with the points. Cells keep no order. Points no longer
// used stay in the list. `neighbors` are those of the mesh before and after, as cell_neighbors() gives them.
// Requires: the mesh holds the cells outside too, and every vertex on its hull is fixed. Complexity: linear
// in the cells, and in the operations tried for the bad ones. Follows: Klingner and Shewchuk, Proc. 16th
// International Meshing Roundtable, 2007; Freitag and Ollivier-Gooch, Int. J. Numer. Methods Eng. 40, 1997.
DihedralStats improve_dihedrals(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                std::vector<std::uint8_t>& fixed, std::span<const VertexPair> fixed_edges,
                                const StructureField& field, std::uint32_t structures,
                                const DrawnSlices& drawn, const DihedralOptions& options,
                                RunContext& context);

// The mesh edges on interfaces that lie along the segments, as fixed_edges wants them: for each segment the
// chain of interface edges along the straight line that joins its ends; where there is none, the edges of
// those that start at its ends, and `missed`, if asked for, receives the segment. Requires: as
// region_facets(). Complexity: linear in the cells and the segments.
std::vector<VertexPair> edges_along(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                    std::span<const VertexPair> segments,
                                    std::vector<VertexPair>* missed = nullptr);

}  // namespace anatomesh
