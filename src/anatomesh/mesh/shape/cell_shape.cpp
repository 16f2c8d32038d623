#include "anatomesh/mesh/shape/cell_shape.h"

#include <algorithm>

#include "anatomesh/base/instruction_sets.h"

namespace anatomesh {

template <bool sine, bool ratio>
ANATOMESH_CLONES CellTerms cell_terms(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const Vec3 ab = b - a, ac = c - a, ad = d - a, bc = c - b, bd = d - b, cd = d - c;
    const Vec3 nb = cross(ac, ad), nc = cross(ad, ab), nd = cross(ab, ac);
    const double ab2 = squared_length(ab), ac2 = squared_length(ac), ad2 = squared_length(ad),
                 bc2 = squared_length(bc), bd2 = squared_length(bd), cd2 = squared_length(cd);
    CellTerms terms;
    terms.volume6 = dot(nd, ad);
    terms.squared_longest = std::max({ab2, ac2, ad2, bc2, bd2, cd2});
    if constexpr (sine) {
        // |n_k| |n_l| sin = 6 volume |edge|, n_k and n_l the normals of the facets at the edge.
        const double fa = squared_length(cross(bc, bd)), fb = squared_length(nb), fc = squared_length(nc),
                     fd = squared_length(nd);
        terms.sine = std::min(
            {ab2 * fa * fb, ac2 * fa * fc, ad2 * fa * fd, bc2 * fb * fc, bd2 * fb * fd, cd2 * fc * fd});
        terms.facets = fa * fb * fc * fd;
    }
    if constexpr (ratio) {
        terms.radius = squared_length(ad2 * nd + ac2 * nc + ab2 * nb);
        terms.shortest = std::min({ab2, ac2, ad2, bc2, bd2, cd2});
    }
    return terms;
}

template CellTerms cell_terms<true, true>(Vec3, Vec3, Vec3, Vec3);
template CellTerms cell_terms<true, false>(Vec3, Vec3, Vec3, Vec3);
template CellTerms cell_terms<false, true>(Vec3, Vec3, Vec3, Vec3);
template CellTerms cell_terms<false, false>(Vec3, Vec3, Vec3, Vec3);

}  // namespace anatomesh
