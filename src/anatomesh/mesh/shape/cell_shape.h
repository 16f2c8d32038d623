// Measures of a cell for hill-climbing: cheap, and smooth but for the choice of the worst edge.
#pragma once

#include <cmath>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// What edges and facets of a cell say about it.
struct CellMeasures {
    double volume6 = 0;          // six volumes
    double squared_sine = 0;     // (least sine of the dihedral angles / six volumes)^2
    double squared_ratio = 0;    // (circumradius / shortest edge)^2, the same figure as radius_edge_ratio()
    double squared_longest = 0;  // edge

    // The least sine of the six dihedral angles; negative for an inverted cell, 0 for a flat one. Bounds the
    // smallest angle from below and the largest from above. (Freitag and Ollivier-Gooch, Int. J. Numer.
    // Methods Eng. 40, 1997.)
    double least_sine() const { return volume6 * std::sqrt(squared_sine); }
};

// The same as numerators and denominators: what only compares needs neither quotients nor roots.
struct CellTerms {
    double volume6 = 0, squared_longest = 0;  // as above
    double sine = 0, facets = 0;              // squared_sine is their quotient
    double radius = 0,
           shortest = 0;  // squared_ratio is radius over 4 volume6^2 times the squared shortest edge
};

// Without `sine` or `ratio` these terms stay 0.
template <bool sine = true, bool ratio = true>
CellTerms cell_terms(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// Without `sine` or `ratio` that figure stays 0.
template <bool sine = true, bool ratio = true>
CellMeasures measure_cell(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const CellTerms terms = cell_terms<sine, ratio>(a, b, c, d);
    CellMeasures measures;
    measures.volume6 = terms.volume6;
    measures.squared_longest = terms.squared_longest;
    if constexpr (sine) measures.squared_sine = terms.sine / terms.facets;
    if constexpr (ratio)
        measures.squared_ratio = terms.radius / (4 * terms.volume6 * terms.volume6 * terms.shortest);
    return measures;
}

inline double least_sine(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    return measure_cell<true, false>(a, b, c, d).least_sine();
}
inline double squared_radius_edge(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    return measure_cell<false, true>(a, b, c, d).squared_ratio;
}

}  // namespace anatomesh
