// trace_label_grid: the boundary of every label of one slice, as chains and rings in pixel coordinates.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/simplify/chains.h"
#include "anatomesh/contour/trace/small_pieces.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// The grey values of the slice: pixel (i, j) is base[i * step_i + j * step_j]; base is null without values.
struct GreySlice {
    const float* base = nullptr;
    std::size_t step_i = 0, step_j = 0;
    double threshold = 0;
};

// One boundary of a label: the directed chains links[first, first + count), each 2 * chain + (1 if backwards). The label
// is on their left in pixel axes (i to the right, j up).
struct TracedRing {
    std::uint16_t label = 0;
    std::uint32_t first = 0, count = 0;
    std::int64_t pixels = 0;  // inside it; negative where the label lies outside of it
};

struct TracedGrid {
    ChainNetwork network;             // points in pixel coordinates: the centre of pixel (i, j) is (i, j)
    std::vector<TracedRing> rings;    // of the labels
    std::vector<TracedRing> outside;  // those of label 0
    std::vector<std::uint32_t> links;
};

// Multi-label marching squares on the dual grid. Points lie on the edges between neighbouring pixel centres whose
// labels differ: at the threshold by linear interpolation if the two grey values lie on its two sides, else half-way.
// Where three labels meet between four pixels, a junction lies at the mean of the crossing points. If the pixels of
// only one diagonal have equal labels, these two are joined. If the pixels of both diagonals have, the lower label is
// joined, so pixels of a structure that touch only at a corner stay apart in the outside. Points stay 1/64 pixel away
// from pixel centres, so that boundaries neither touch nor vanish. They stay 0.15 pixel away where more than one piece
// of boundary passes the centre, or where the pixel is alone.
// Guarantees: chains touch at junctions only; every ring is a simple polygon.
TracedGrid trace_label_grid(const LabelGrid& grid, const GreySlice& grey);

// Returns the points of a ring in order, as indices into network.points.
void append_ring_points(const TracedGrid& traced, const TracedRing& ring, std::vector<std::uint32_t>& points);

}  // namespace anatomesh
