// resolve_pinches: cells that are to go to the other side of a structure meet it in facets wherever they meet
// it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

struct PinchedSides {
    std::uint32_t structure = 0;
    Region own = 0, to = 0;      // of cells that go; of the side where they go
    bool others_may_go = false;  // at vertices cells of other regions too
    double thickness = 0.5;      // of what goes besides, as a share of edges. (0, 1)
    // Vertices of the membrane that they are the neighbourhood of; rising.
    std::span<const std::uint32_t> membrane;
    std::uint32_t first_new = 0;  // vertices from here on were made for them
};

// Where they meet the other side in an edge or a vertex alone, it would be no manifold: cells between them go
// too, near the edge or the vertex - edges that lead off it are cut, but those of contours -, the fewest, at
// a vertex by ways with few edges of contours; and where these part a region, the structure, or what is not
// the other side at a vertex, one part stays there, that of most contours, and what is near the vertex of
// others goes. Where that brings about such edges and vertices, these in turn, three times.
// `given`: cells of `own`. Returns the cells that are to go then, cut as they are, with the regions they had;
// rising; nothing where a cell would not be positive: what was done to the mesh is the caller's to take
// back then. Whether all is a manifold is not checked. Same result every time. Complexity: O(cells there,
// squared). Errors: none.
std::optional<std::vector<std::uint32_t>> resolve_pinches(EditContext& edit, const PinchedSides& sides,
                                                          std::vector<std::uint32_t> relabelled);

}  // namespace anatomesh
