#include "anatomesh/reconcile/move/movement_nodes.h"

#include <gtest/gtest.h>

#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh::movement_nodes_test {
namespace {

using namespace crossing_fixtures;

// An arc keeps the order of its points and comes over the line as a whole, by the clearance at least.
TEST(MovementNodes, an_arc_comes_over_the_line_and_becomes_flat) {
    for (const double clearance : {0.1, 0.5, 2.0}) {
        for (const double top : {0.0, 0.01, 0.3, 8.0}) {
            double before = 0;
            for (int n = 0; n <= 10; ++n) {
                const double height = top * n / 10;
                const double beyond = distance_across(height, top, clearance) - height;
                EXPECT_GE(beyond, least_clearance_mm * (1 - 1e-12));  // but for rounding
                EXPECT_LE(beyond, clearance + top);
                if (n > 0) {
                    EXPECT_LE(beyond, before);
                }
                before = beyond;
            }
        }
    }
}

struct Crossing {
    ContourSet set;
    ContourGraph graph;
    EndpointPlaces ends;
    EndpointGroups groups;
};

Crossing crossing_of(double noise) {
    std::mt19937 random(4);
    Crossing crossing;
    crossing.set = drawn_ball(20, three_stacks(15, 7, 0.05), {0, noise}, random);
    const std::vector<PlanePatch> patches = plane_patches(crossing.set);
    RunContext context;
    const std::vector<LineComparison> comparisons =
        compare_planes(crossing.set, patches, crossing_pairs(patches, 5), 5, context);
    crossing.graph = make_contour_graph(crossing.set);
    crossing.ends = place_endpoints(crossing.set, crossing.graph, comparisons);
    crossing.groups = group_endpoints(crossing.set, crossing.ends, comparisons);
    return crossing;
}

// Cutting segments loses nothing of the contours' length, and leaves no edge without length.
TEST(MovementNodes, edges_are_the_segments_cut_at_the_places) {
    const Crossing crossing = crossing_of(0.5);
    const std::vector<MovementEdge> edges = movement_edges(crossing.set, crossing.graph, crossing.ends);
    EXPECT_EQ(edges.size(),
              crossing.graph.segments.size() + crossing.ends.places.size() - crossing.ends.on_nodes);
    double cut = 0, whole = 0;
    for (const MovementEdge& edge : edges) {
        EXPECT_GT(edge.length, 0);
        cut += edge.length;
    }
    const auto at = [&](std::uint32_t node) {
        return crossing.set.points[crossing.graph.point_of_node[node]];
    };
    for (const auto& [low, high] : crossing.graph.segments) whole += length(at(high) - at(low));
    EXPECT_NEAR(cut, whole, 1e-3);
}

TEST(MovementNodes, arcs_are_pinned_but_anchors_stay) {
    const Crossing crossing = crossing_of(0.5);
    std::vector<MovementNode> nodes = movement_nodes(crossing.graph, crossing.ends, crossing.groups);
    EXPECT_EQ(nodes.size(),
              crossing.graph.point_of_node.size() + crossing.ends.places.size() - crossing.ends.on_nodes);
    Arc arc;
    arc.back = {0, 1};
    arc.height_mm = 2;
    const std::size_t anchor = crossing.graph.node_of_point[1];
    nodes[anchor] = {Hold::anchor, 0, 0, {1, 0}};
    for (const std::uint32_t k : {0u, 1u, 2u}) {
        arc.points.push_back(k);
        arc.heights_mm.push_back(k == 1 ? 2 : 1);
    }
    pin_arc(arc, 0.5, crossing.graph, nodes);
    EXPECT_EQ(nodes[anchor].hold, Hold::anchor);
    const MovementNode& first = nodes[crossing.graph.node_of_point[0]];
    EXPECT_EQ(first.hold, Hold::pinned);
    EXPECT_NEAR(first.direction.y, distance_across(1, 2, 0.5), 1e-12);
    // A point that another arc takes further goes there.
    arc.heights_mm.assign(3, 0);
    arc.height_mm = 0;
    pin_arc(arc, 0.1, crossing.graph, nodes);
    EXPECT_NEAR(nodes[crossing.graph.node_of_point[0]].direction.y, distance_across(1, 2, 0.5), 1e-12);
}

}  // namespace
}  // namespace anatomesh::movement_nodes_test
