// The Jacobian determinant of a quadratic tetrahedron, bounded over the whole element.
#pragma once

#include <array>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Corners as in a Cell, then the nodes on its cell_edges.
struct QuadraticElement {
    std::array<Vec3, 4> corners;
    std::array<Vec3, 6> mid_nodes;
};

// Coefficients of the Jacobian determinant, a cubic over the element, in Bezier form: every value of it lies
// between the least and the largest coefficient, and those at the corners are its values there. With
// mid-nodes in the middles all are 6 times the volume. Follows: Johnen, Remacle, Geuzaine, "Geometrical
// validity of curvilinear finite elements", J. Comput. Phys. 233, 2013.
std::array<double, 20> jacobian_coefficients(const QuadraticElement& element);

// The least coefficient over 6 times the volume of the straight element: above 0 the Jacobian is positive
// everywhere in the element. Requires: the straight element is positive.
double least_jacobian(const QuadraticElement& element);

// The volume of the element: exact, the mean of the coefficients over 6.
double quadratic_volume(const QuadraticElement& element);

// The Jacobian determinant at barycentric coordinates.
double jacobian_at(const QuadraticElement& element, const std::array<double, 4>& barycentric);

}  // namespace anatomesh
