// distance_raster: the signed distance to a drawn region at every point of a pixel grid.
#pragma once

#include <span>
#include <vector>

#include "anatomesh/field/slice/scanline.h"

namespace anatomesh {

// The distance map DM of Archip et al. (2006) as an image: element j * nx + i is the distance in mm of grid
// point (i, j) from the boundary, negative inside (even-odd), positive outside, without an upper bound.
// Exact: the distance is to the polygons themselves, within some 1e-13 of the coordinates.
//
// Every edge gives its distance to the grid points of the strip square to it, every vertex to those of the
// wedge between the strips of its two edges; each point keeps the least. Strips end where another point of
// the boundary is nearer: what is nearest to a point is so along the whole way from there, so that a single
// look at an upper bound of the distance (that to the best of a few boundary points, spread over a coarse
// grid) cuts off all that lies beyond. Wedges are cut by the bisectors with such boundary points, as Voronoi
// cells are. The sign is the scanline's.
//
// Requires: at least one edge; the edges bound a region, closed. Complexity: about the grid points, plus the
// rows of all strips and wedges; n nx ny at worst. Follows: Mauch, "Efficient algorithms for solving static
// Hamilton-Jacobi equations", 2003 (closest points by scan conversion).
std::vector<double> distance_raster(std::span<const Edge2> edges, const PixelGrid& grid);

}  // namespace anatomesh
