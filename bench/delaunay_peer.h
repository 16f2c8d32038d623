// CGAL's Delaunay tetrahedralization, to compare with.
#pragma once

#include <cstddef>
#include <span>

#include "anatomesh/geom/vec.h"

// How many cells CGAL's sequential Delaunay_triangulation_3 makes of the points, inserted in its spatial
// order.
std::size_t cells_by_cgal(std::span<const anatomesh::Vec3> points);
