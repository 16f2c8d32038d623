// ContourGraph: the contours of a set as a graph in which what contours share exists once, and the places
// on it where contours pass other slices' planes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// It stands for a place inside a segment. [index; 2^32 - 1; D]
inline constexpr std::uint32_t no_node = 0xffffffffu;

// Nodes are the distinct points of each slice.
struct ContourGraph {
    std::vector<std::uint32_t> node_of_point;  // per point of the set
    std::vector<std::uint32_t> slice_of_node;
    std::vector<std::uint32_t> point_of_node;            // one of its points
    std::vector<std::array<std::uint32_t, 2>> segments;  // distinct, of two nodes, lower first
    std::vector<std::uint32_t> segment_of_point;         // per point: the segment from it to the next one
};

// O(n log n).
ContourGraph make_contour_graph(const ContourSet& set);

// Returns, per point of the set, whether it stays where one slice's contours move: where several slices
// have it, and where contours of its slice branch. O(n log n).
std::vector<bool> points_that_stay(const ContourSet& set, const ContourGraph& graph);

// A place of the graph: a node, or a place inside a segment.
struct GraphPlace {
    std::uint32_t node = no_node;  // no_node: inside the segment
    std::uint32_t segment = 0;
    double distance = 0;  // from the segment's lower node, mm
    Vec3 at;
};

// The endpoints of all comparisons as places, one entry for each distinct place.
struct EndpointPlaces {
    std::vector<GraphPlace>
        places;                // those on nodes by node, then those inside segments by segment and distance
    std::size_t on_nodes = 0;  // the number of the former
    // Per comparison, per end of each side: index into places.
    std::vector<std::vector<std::uint32_t>> of_a, of_b;
};

// Finds the places of all endpoints. Those on one segment that differ by rounding are one. O(n log n).
EndpointPlaces place_endpoints(const ContourSet& set, const ContourGraph& graph,
                               std::span<const LineComparison> comparisons);

// Contours' normals are taken over chords of this half length where endpoints move. [mm; > 0; M 2026-11, set
// not recorded]
inline constexpr double moving_chord_mm = 1;
// They are taken over longer chords where disagreement is measured: these see less of the noise of drawing.
// [mm; > 0; M 2026-11, set not recorded]
inline constexpr double measuring_chord_mm = 2;

// Returns the unit normal of the contour at an endpoint, in the frame of its slice. It is taken across the
// chord of the contour that reaches at least `reach` mm, or one segment, to both sides. O(points within
// reach).
Vec2 contour_normal(const ContourSet& set, const IntervalEndpoint& end, double reach);

}  // namespace anatomesh
