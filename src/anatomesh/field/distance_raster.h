// distance_raster: the signed distance to a drawn region at every point of a pixel grid.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/field/scanline.h"

namespace anatomesh {

// The distance map DM of Archip et al. (2006) as an image: element j * nx + i is the distance in mm of grid
// point (i, j) from the boundary, negative inside (even-odd), positive outside, without an upper bound.
// Exact: the distance is to the polygons themselves, within some 1e-13 of the coordinates.
//
// Every edge gives its distance to the grid points of the strip square to it, every vertex to those of the
// wedge between the strips of its two edges; each point keeps the least. The sign is the scanline's.
//
// Requires: at least one edge; the edges bound a region, closed. Complexity: the grid points in all strips
// and wedges; for contours of n points in general n (nx + ny), at most n nx ny. Follows: Mauch, "Efficient
// algorithms for solving static Hamilton-Jacobi equations", 2003 (closest points by scan conversion).
std::vector<double> distance_raster(std::span<const Edge2> edges, const PixelGrid& grid);

}  // namespace anatomesh
