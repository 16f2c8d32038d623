// flip_surface_edges: flips edges of surfaces where neighbouring facets then meet at smaller angles.
#pragma once

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

struct FlipOptions {
    double least_gain_degrees =
        3;            // of a flip: by how much the five angles at the two facets fall together. > 0
    int rounds = 40;  // over what the flips of the round before have changed or left. [0, 1000]
    double good_sine =
        0;  // least sine that cells inside may fall to; below it they may not get worse. [0, 1]
};

// Vertices that lie on a curved surface leave open which diagonal of two neighbouring facets is an edge; of
// the two the one is taken with which the facets meet each other and the four round them at the smaller
// angles, added up. The sum keeps creases where they are. In each round those that gain most and share no
// vertex are flipped at the same time. Guarantees: as improve_mesh(), with `good_sine` for the least
// sine that cells may fall to; points do not move; edges where three regions meet and fixed edges stay; the
// same for any `threads`. Appends to `changed` the cells made that are still there. Complexity: linear in the
// cells and the flips tried. Follows: Dyn, Levin and Rippa, IMA J. Numer. Anal. 10, 1990 (angles between
// normals), and Dyn, Hormann, Kim and Levin, in: Mathematical Methods for Curves and Surfaces, Oslo 2000
// (closed surfaces).
void flip_surface_edges(EditContext& edit, const FlipOptions& options, int threads,
                        std::vector<std::uint32_t>& changed);

}  // namespace anatomesh
