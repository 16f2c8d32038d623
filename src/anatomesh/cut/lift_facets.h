// lift_facets: no facet of a structure's surface stays in a slice's plane beside what is drawn there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/field/structure_field.h"
#include "anatomesh/mesh/tet_mesh.h"

namespace anatomesh {

inline constexpr std::uint32_t no_slice = 0xFFFFFFFFu;

struct LiftOptions {
    // Of the new vertex over the facet, as a share of the way to the vertex opposite. (0, 1)
    double height = 0.2;
    // The new cells' ratios may be up to this, or to that of the cell; else the vertex goes higher, in steps
    // of its height up to three, or the facet stays. [1.2, 10]
    double max_radius_edge = 2.5;
};

struct LiftStats {
    std::uint64_t facets_lifted = 0, facets_left = 0;  // the latter for the sake of the cells' shapes
};

// A cell in a structure that rests with a facet on the plane of a slice, between contour vertices and outside
// what is drawn of that structure, makes the model's cut larger than the drawing, although its surface is as
// good as where it belongs: where a structure widens from one slice to the next it starts in the plane
// itself. Such a cell is split from a new vertex over the middle of the facet, and the part below it goes to
// the region across the facet. Only where that region is the one drawn there: the surface stays a manifold,
// with the facet's edges on it. `slice_of`: for every point of the mesh the slice in whose plane it lies as a
// part of a contour, or no_slice. `neighbors`: those of the cells (cell_neighbors()); kept up to date.
// Guarantees: no vertex moves, all cells positive (checked exactly). Complexity: O(cells). Errors: none.
LiftStats lift_facets(TetMesh& mesh, std::vector<std::uint32_t>& neighbors, const RegionTable& table,
                      std::span<const std::uint32_t> slice_of, const StructureField& field,
                      const LiftOptions& options = {}, int threads = 1);

}  // namespace anatomesh
