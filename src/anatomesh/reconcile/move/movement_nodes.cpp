#include "anatomesh/reconcile/move/movement_nodes.h"

#include <algorithm>
#include <cstddef>

namespace anatomesh {

namespace {

// This share is left of the height of an arc that is drawn back. [1; 0 to 1; M 2026-11, set not recorded]
constexpr double flattening = 0.2;

}  // namespace

std::vector<MovementNode> movement_nodes(const ContourGraph& graph, const EndpointPlaces& ends,
                                         const EndpointGroups& groups) {
    const std::size_t own = graph.point_of_node.size();
    std::vector<MovementNode> nodes(own + ends.places.size() - ends.on_nodes);
    for (std::size_t p = 0; p < ends.places.size(); ++p) {
        MovementNode& node = nodes[p < ends.on_nodes ? ends.places[p].node : own + p - ends.on_nodes];
        const EndpointGroups::Member& member = groups.members[p];
        if (member.group == no_node) continue;
        if (member.pinned) {
            node = {Hold::pinned, 0, 0, member.direction};
        } else {
            node = {Hold::anchor, member.group, member.place, member.direction};
        }
    }
    return nodes;
}

std::vector<MovementEdge> movement_edges(const ContourSet& set, const ContourGraph& graph,
                                         const EndpointPlaces& ends) {
    std::vector<MovementEdge> edges;
    const auto link = [&](std::uint32_t a, std::uint32_t b, double length) {
        edges.push_back({a, b, std::max(length, beside_plane_mm)});
    };
    std::size_t next = ends.on_nodes;
    for (std::uint32_t s = 0; s < graph.segments.size(); ++s) {
        const auto [low, high] = graph.segments[s];
        std::uint32_t last = low;
        double reached = 0;
        for (; next < ends.places.size() && ends.places[next].segment == s; ++next) {
            const auto node = static_cast<std::uint32_t>(graph.point_of_node.size() + next - ends.on_nodes);
            link(last, node, ends.places[next].distance - reached);
            last = node;
            reached = ends.places[next].distance;
        }
        const double whole =
            length(set.points[graph.point_of_node[high]] - set.points[graph.point_of_node[low]]);
        link(last, high, whole - reached);
    }
    return edges;
}

double distance_across(double height_mm, double arc_height_mm, double clearance_mm) {
    const double kept_mm = std::clamp(arc_height_mm, least_clearance_mm, clearance_mm);
    return height_mm + kept_mm + flattening * (arc_height_mm - height_mm);
}

void pin_arc(const Arc& arc, double clearance_mm, const ContourGraph& graph,
             std::vector<MovementNode>& nodes) {
    for (std::size_t n = 0; n < arc.points.size(); ++n) {
        const double distance = distance_across(arc.heights_mm[n], arc.height_mm, clearance_mm);
        MovementNode& node = nodes[graph.node_of_point[arc.points[n]]];
        if (node.hold == Hold::anchor) continue;
        if (node.hold == Hold::pinned && squared_length(node.direction) > distance * distance) continue;
        node = {Hold::pinned, 0, 0, distance * arc.back};
    }
}

}  // namespace anatomesh
