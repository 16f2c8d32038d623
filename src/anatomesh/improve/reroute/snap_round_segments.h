// snap_round_segments: contours take edges of the surface beside segments that no edges run along.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/mesh/model/routed_contour.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// How far models let contours be re-routed over edges, in edge lengths: as far as it is round the facets at
// one that is longer than most. [1; > 0; M 2026-11 dense freehand planes]
inline constexpr double most_sizes_beside = 0.6;

struct SnapRoundingOptions {
    double most_mm = 0;  // no way is further from what it replaces, nor that from it. > 0
    int threads = 1;
};

// Where many planes cross at less than a degree, their contours run hundredths of a millimetre beside each
// other. An edge along each of them would need cells as thin, and the mesh has the edges of one of them
// alone. There a way over edges of the structure's surface takes the place of a missed segment:
// - It leads from one end of the segment to the other and keeps nearest to it: the integral of the distance
//   from it is the least. As a rule that is the contour beside it, a little off the plane.
// - It passes no other vertex of the slice's contours of the structure. All drawn vertices stay on their
//   contours.
// - Structures that share a segment go the same way in its place where that is edges of both. Those that
//   exclude each other keep out of each other elsewhere.
// - Where ways make contours of a slice touch, cross or turn over, projected along its normal, others are
//   sought, or segments stay missed. So do all segments of a slice of which the mesh has lost a vertex.
// The mesh stays as it is.
//
// `vertex_of`: the vertex of every point of the set, or no_cell. `routed`: contours that were re-routed
// already, in the order of the contours (reroute_on_section.h). Returns these and those that are re-routed
// now, in that order. Requires: as region_facets(). Same result at any number of threads. Complexity:
// O(cells) a structure, and for each segment missed O(n log n) in the surface's vertices within `most_mm` of
// it. Follows: Dijkstra, Numer. Math. 1, 1959; that lines too near for cells between them share one is snap
// rounding (Hobby, Computational Geometry 13, 1999), here onto edges that are there.
std::vector<RoutedContour> snap_round_segments(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                               const RegionTable& regions, const ContourSet& set,
                                               std::span<const std::uint32_t> vertex_of,
                                               std::vector<RoutedContour> routed,
                                               const SnapRoundingOptions& options);

}  // namespace anatomesh
