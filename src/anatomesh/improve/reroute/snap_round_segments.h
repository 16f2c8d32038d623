// snap_round_segments: contours with segments that no edges of the surface run along take the edges beside
// these.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/mesh/model/routed_contour.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// How far models let contours be re-routed over edges, in edge lengths: as far as it is round the facets at
// one that is longer than most.
inline constexpr double most_sizes_beside = 0.6;

struct SnapRoundingOptions {
    double most_mm = 0;  // no way is further from what it replaces, nor that from it. > 0
    int threads = 1;
};

// Where contours of many planes that cross at less than a degree run hundredths of a millimetre beside each
// other, an edge along each of them needs cells as thin, and the mesh has the edges of one of them alone. The
// way over edges of the structure's surface, from one end of a missed segment to the other, that keeps
// nearest to the segment - the least integral of the distance from it - takes its place: as a rule along the
// contour beside it, a little off the plane. It passes no other vertex of the slice's contours of the
// structure. All drawn vertices stay on their contours. Structures that share a segment go the same way in
// its place where that is edges of both; those that exclude each other keep out of each other elsewhere.
// Where ways make contours of a slice touch, cross or turn over, projected along its normal, others are
// sought, or segments stay missed; so do all of a slice of which the mesh has lost a vertex. The mesh stays
// as it is. `vertex_of`: the vertex of every point of the set, or no_cell; `routed`: contours that were
// re-routed already, in the order of the contours (reroute_on_section.h). Returns these and those that are
// re-routed now, in that order. Requires: as region_facets(). Same result at any number of threads.
// Complexity: O(cells) a structure, and for each segment missed O(n log n) in the surface's vertices within
// `most_mm` of it. Follows: Dijkstra, Numer. Math. 1, 1959; that lines too near for cells between them share
// one is snap rounding (Hobby, Computational Geometry 13, 1999), here onto edges that are there.
std::vector<RoutedContour> snap_round_segments(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                               const RegionTable& regions, const ContourSet& set,
                                               std::span<const std::uint32_t> vertex_of,
                                               std::vector<RoutedContour> routed,
                                               const SnapRoundingOptions& options);

}  // namespace anatomesh
