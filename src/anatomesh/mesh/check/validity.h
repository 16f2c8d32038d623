// check_mesh: whether a tetrahedral mesh is what it must be, found from points and cells alone.
//
// No overlap is proved as follows. All cells are positive, and every facet lies in one cell (the boundary) or
// in two, on opposite sides; so the number of cells that cover a point of space is the winding number of the
// boundary about it, and changes by exactly one across a boundary facet. The boundary's triangles meet in
// nothing but the vertices and edges that they share, so that number is constant beside each shell; one exact
// ray from each shell shows it is 0 just outside. Hence it is 0 or 1 everywhere. (The sum of the cells'
// volumes equals the signed volume of the boundary identically once facets match; alone it would not see a
// cell wound twice, or a shell inside a solid.)
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

enum class MeshFault : std::uint8_t {
    point_not_finite,         // first: point
    points_equal,             // first, second: points at the same place
    point_unused,             // first: point
    index_out_of_range,       // first: cell
    cell_inverted,            // first: cell with a negative orientation
    cell_flat,                // first: cell whose vertices lie in a plane
    cells_equal,              // first, second: cells with the same four vertices
    facet_in_too_many_cells,  // first, second: two of the cells
    facet_on_one_side,        // first, second: the cells, which lie on the same side of their facet
    boundary_crosses,         // first, second: cells of two boundary facets that cross or touch
    shell_inside_a_solid,     // first: cell at the shell
};

struct MeshFinding {
    MeshFault fault;
    std::uint32_t first = 0, second = no_cell;
};

struct MeshCheck {
    // How often each fault was found, by MeshFault.
    std::array<std::uint64_t, 11> counts{};
    std::vector<MeshFinding> examples;  // the first of each fault, at most 10 of each
    std::uint64_t boundary_triangles = 0, shells = 0;
    // False when earlier faults (indices, orientation, facets) leave no boundary to check for crossings.
    bool boundary_checked = false;

    std::uint64_t count(MeshFault fault) const { return counts[static_cast<std::size_t>(fault)]; }
    // No fault that makes the mesh wrong; unused points are a blemish.
    bool valid() const;
};

// "no fault in 250000 cells" or "3 cells inverted (first: cell 17), 1 ..."; one line.
std::string to_line(const MeshCheck& check);

// Complexity: O(n log n); 250,000 cells with 100,000 boundary facets take about 0.4 s on one thread.
// Exact: every decision is a predicate on the given doubles, but for the point from which a shell's ray
// starts, the rounded centroid of a boundary facet. `neighbors`, if given, receives what cell_neighbors()
// gives, as it comes with the check of the facets; nothing when points or indices leave no facets to check.
// Same result at any number of threads.
MeshCheck check_mesh(const TetMesh& mesh, int threads = 1, std::vector<std::uint32_t>* neighbors = nullptr);

}  // namespace anatomesh
