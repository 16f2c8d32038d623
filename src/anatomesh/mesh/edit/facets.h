// match_facets: which facets of the cells of a mesh are the same triangle.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Facets go by their ids, 4 * cell + index.
struct FacetPairs {
    std::vector<std::uint32_t> other;  // by facet: the one it is joined with, no_cell when there is none
    // Joined facets whose cells, if both are positive, lie on the same side: each pair once, the smaller id
    // first.
    std::vector<std::array<std::uint32_t, 2>> on_one_side;
    // A third or further facet with the same vertices as two joined ones, after the first of these.
    std::vector<std::array<std::uint32_t, 2>> surplus;
};

// Joins the first two facets, by id, that have the same three vertices. Requires: indices below point_count,
// fewer than 2^30 cells. Same result at any number of threads. Complexity: linear for a bounded number of
// facets at a vertex.
FacetPairs match_facets(std::span<const Cell> cells, std::size_t point_count, int threads = 1);

// neighbors[4 c + i] is the cell across facet i of cell c, no_cell on the boundary of the mesh.
// Requires: no facet in more than two cells (check_mesh() counts them; here the first two are joined),
// indices below point_count. Complexity: O(cells), see match_facets().
std::vector<std::uint32_t> cell_neighbors(std::span<const Cell> cells, std::size_t point_count,
                                          int threads = 1);

}  // namespace anatomesh
