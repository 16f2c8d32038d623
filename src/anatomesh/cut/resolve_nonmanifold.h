// resolve_nonmanifold: the last few non-manifold edges and vertices are resolved by local subdivision.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/cut/cut_corners.h"
#include "anatomesh/mesh/model/region_registry.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

struct NonmanifoldOptions {
    double corner = 0.5;   // where the edges at a split vertex are cut, as a share of their length. (0, 1)
    double spindle = 0.5;  // how far a split edge's spindle reaches towards its ring. (0, 1)
    int max_passes = 200;  // a pass splits all non-manifold edges, or vertices, that share no cell. >= 1
};

struct NonmanifoldStats {
    std::uint64_t edges_split = 0, vertices_split = 0, vertices_joined = 0;
    std::uint64_t points_added = 0, cells_added = 0;
    std::uint64_t components_relabelled = 0;  // of stars, where no split had room
    CutSubsegments segments;
};

// Makes the surfaces of all bodies manifold at `vertices`, by three moves, in this order:
// 1. *Join*: a contour vertex whose cells all lie on one side of its structure is joined to the other side by the
//    shortest path of cells; with none near, one cell at it starts a component of that side.
// 2. *Spindle*: at an edge round which a structure lies in two or more arcs, a spindle of cells along the edge is
//    cut out of its ring, and one arc of the spindle is relabelled to the region beside it. Each spindle
//    makes one edge manifold and no other edge non-manifold.
// 3. *Corner*: at a vertex whose edges are manifold but whose star a structure cuts into several discs, the corners
//    of the star's cells are cut off, and the corners are given to one side or the other so that one disc stays:
//    the surface keeps passing through the vertex. Of all such discs, and of all paths of corners that join
//    two components of one side instead, the one is taken that leaves most contour vertices and subsegments
//    of contour segments on their surface, then a disc before a path, and the one that changes least.
// Where none of them has room, beside a cell that is nearly flat, the smallest component too many of each
// vertex left goes to the region round it, twenty times at most: what that leaves non-manifold is split where
// it has room. Guarantees on success: every vertex of the mesh is manifold; no vertex moved; facets away from the
// split cells unchanged; all cells positive, and new ones exactly in the place of the old ones (both checked,
// as rounding may turn one that is nearly flat: that edge or vertex is not split then); the tetrahedra
// outside the stars of `vertices` untouched. Errors: geometry E-CUT-001 when a vertex stays non-manifold
// after max_passes, or because neither it nor what relabelling components left has room, with its place. Why
// it ends, for one structure: relabelling a regular neighbourhood of the singular set (Rourke and Sanderson,
// Introduction to Piecewise-Linear Topology, 1972, chapter 3). With several structures at one vertex
// max_passes bounds it.
Result<NonmanifoldStats> resolve_nonmanifold(TetMesh& mesh, const std::vector<std::uint32_t>& vertices,
                                             const ContourOwners& owners, RegionRegistry& registry,
                                             const NonmanifoldOptions& options);

}  // namespace anatomesh
