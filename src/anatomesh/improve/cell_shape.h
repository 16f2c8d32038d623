// Measures of a cell for hill-climbing: cheap, and smooth but for the choice of the worst edge.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// The least sine of the six dihedral angles; negative for an inverted cell, 0 for a flat one. Bounds the
// smallest angle from below and the largest from above. (Freitag and Ollivier-Gooch, Int. J. Numer. Methods
// Eng. 40, 1997.)
inline double least_sine(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const Vec3 ab = b - a, ac = c - a, ad = d - a, bc = c - b, bd = d - b, cd = d - c;
    const Vec3 nd = cross(ab, ac);
    const double volume6 = dot(nd, ad);
    const double fa = squared_length(cross(bc, bd)), fb = squared_length(cross(ac, ad)),
                 fc = squared_length(cross(ab, ad)), fd = squared_length(nd);
    // |n_k| |n_l| sin = 6 volume |edge|, n_k and n_l the normals of the facets at the edge.
    const double least = std::min({squared_length(ab) / (fc * fd), squared_length(ac) / (fb * fd),
                                   squared_length(ad) / (fb * fc), squared_length(bc) / (fa * fd),
                                   squared_length(bd) / (fa * fc), squared_length(cd) / (fa * fb)});
    return volume6 * std::sqrt(least);
}

// Circumradius / shortest edge, squared; the same figure as radius_edge_ratio().
inline double squared_radius_edge(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const Vec3 ab = b - a, ac = c - a, ad = d - a;
    const double b2 = squared_length(ab), c2 = squared_length(ac), d2 = squared_length(ad);
    const Vec3 normal = cross(ab, ac);
    const double volume6 = dot(normal, ad);
    const Vec3 offset = d2 * normal + c2 * cross(ad, ab) + b2 * cross(ac, ad);
    const double shortest =
        std::min({b2, c2, d2, squared_length(c - b), squared_length(d - b), squared_length(d - c)});
    return squared_length(offset) / (4 * volume6 * volume6 * shortest);
}

}  // namespace anatomesh
