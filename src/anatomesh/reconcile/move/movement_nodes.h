// movement_nodes, movement_edges: the contours' graph with its places as the nodes and edges of a movement.
#pragma once

#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/reconcile/move/endpoint_groups.h"
#include "anatomesh/reconcile/move/movement.h"
#include "anatomesh/slices/lines/arc.h"

namespace anatomesh {

// Contours that are drawn back keep this distance at least from the other slice's plane. Nearer to the line
// two planes are so close to each other that no cells of any shape fit between.
// [mm; > 0; M 2026-11 40 random sets about an axis]
inline constexpr double least_clearance_mm = 0.1;
// They also keep this share of the mean distance between vertices.
// [1; 0 to 1; M 2026-11 40 random sets about an axis]
inline constexpr double clearance_share = 0.1;

// Per node of the graph, and then per place inside a segment: an anchor on the line of its group, pinned
// where lines of several planes meet, or free. O(nodes + places).
std::vector<MovementNode> movement_nodes(const ContourGraph& graph, const EndpointPlaces& ends,
                                         const EndpointGroups& groups);

// The graph's segments, cut at the places inside them. Every edge has a positive length. O(segments +
// places).
std::vector<MovementEdge> movement_edges(const ContourSet& set, const ContourGraph& graph,
                                         const EndpointPlaces& ends);

// How far a point at `height_mm` over a line is moved across it, as one of an arc that is `arc_height_mm`
// high. All of the arc comes over the line, its points nearest to the line farthest, so that it becomes flat.
// A low arc needs less clearance beyond the line: it is not taken far from where it was drawn. Never less
// than the height, mm. Requires: 0 <= height_mm <= arc_height_mm, clearance_mm >= least_clearance_mm.
double distance_across(double height_mm, double arc_height_mm, double clearance_mm);

// Pins the points of an arc to the other side of its line. Anchors stay what they are, and a point that is
// pinned to go further stays so. O(points of the arc).
void pin_arc(const Arc& arc, double clearance_mm, const ContourGraph& graph,
             std::vector<MovementNode>& nodes);

}  // namespace anatomesh
