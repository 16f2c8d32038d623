#include "anatomesh/reconcile/move/contour_graph.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace anatomesh {

ContourGraph make_contour_graph(const ContourSet& set) {
    ContourGraph graph;
    graph.node_of_point.resize(set.points.size());
    graph.segment_of_point.resize(set.points.size());
    std::vector<std::uint32_t> slice_of(set.points.size()), order(set.points.size());
    for (const Contour& contour : set.contours) {
        std::fill_n(slice_of.begin() + contour.first_point, contour.point_count, contour.slice);
    }
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) {
        if (slice_of[p] != slice_of[q]) return slice_of[p] < slice_of[q];
        if (set.points[p] != set.points[q]) return lexicographic_less(set.points[p], set.points[q]);
        return p < q;
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && slice_of[order[i]] == slice_of[order[i - 1]] &&
                          set.points[order[i]] == set.points[order[i - 1]];
        if (!same) {
            graph.slice_of_node.push_back(slice_of[order[i]]);
            graph.point_of_node.push_back(order[i]);
        }
        graph.node_of_point[order[i]] = static_cast<std::uint32_t>(graph.point_of_node.size() - 1);
    }
    std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> all;  // two nodes, the point
    for (const Contour& contour : set.contours) {
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            const std::uint32_t a = graph.node_of_point[k], b = graph.node_of_point[point_after(contour, k)];
            all.emplace_back(std::min(a, b), std::max(a, b), k);
        }
    }
    std::sort(all.begin(), all.end());
    for (const auto& [a, b, point] : all) {
        if (graph.segments.empty() || graph.segments.back() != std::array{a, b})
            graph.segments.push_back({a, b});
        graph.segment_of_point[point] = static_cast<std::uint32_t>(graph.segments.size() - 1);
    }
    return graph;
}

std::vector<bool> points_that_stay(const ContourSet& set, const ContourGraph& graph) {
    std::vector<std::uint32_t> degree(graph.point_of_node.size(), 0), order(set.points.size());
    for (const auto& segment : graph.segments) {
        for (const std::uint32_t node : segment) ++degree[node];
    }
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) {
        return lexicographic_less(set.points[p], set.points[q]);
    });
    std::vector<bool> stays(set.points.size(), false);
    for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
        const std::uint32_t node = graph.node_of_point[order[first]];
        bool stay = degree[node] > 2;
        for (; last < order.size() && set.points[order[last]] == set.points[order[first]]; ++last)
            stay = stay || graph.node_of_point[order[last]] != node;  // another slice's
        for (std::size_t n = first; n < last; ++n) stays[order[n]] = stay;
    }
    return stays;
}

EndpointPlaces place_endpoints(const ContourSet& set, const ContourGraph& graph,
                               std::span<const LineComparison> comparisons) {
    struct Found {
        GraphPlace place;
        std::uint32_t comparison, end;
        bool of_a;
    };
    std::vector<Found> found;
    EndpointPlaces result;
    for (std::uint32_t c = 0; c < comparisons.size(); ++c) {
        for (const bool of_a : {true, false}) {
            const std::vector<IntervalEndpoint>& ends =
                of_a ? comparisons[c].endpoints_a : comparisons[c].endpoints_b;
            (of_a ? result.of_a : result.of_b).emplace_back(ends.size());
            for (std::uint32_t e = 0; e < ends.size(); ++e) {
                GraphPlace place{no_node, 0, 0, ends[e].at};
                if (ends[e].from == ends[e].to) {
                    place.node = graph.node_of_point[ends[e].from];
                } else {
                    place.segment = graph.segment_of_point[ends[e].from];
                    const std::uint32_t low = graph.segments[place.segment][0];
                    place.distance = length(ends[e].at - set.points[graph.point_of_node[low]]);
                }
                found.push_back({place, c, e, of_a});
            }
        }
    }
    std::stable_sort(found.begin(), found.end(), [](const Found& p, const Found& q) {
        const bool p_inside = p.place.node == no_node, q_inside = q.place.node == no_node;
        if (p_inside != q_inside) return q_inside;
        if (!p_inside) return p.place.node < q.place.node;
        return std::tie(p.place.segment, p.place.distance) < std::tie(q.place.segment, q.place.distance);
    });
    for (const Found& f : found) {
        const bool same = !result.places.empty() && result.places.back().node == f.place.node &&
                          result.places.back().segment == f.place.segment &&
                          f.place.distance - result.places.back().distance <= 2 * line_in_plane_mm;
        if (!same) result.places.push_back(f.place);
        if (f.place.node != no_node) result.on_nodes = result.places.size();
        (f.of_a ? result.of_a : result.of_b)[f.comparison][f.end] =
            static_cast<std::uint32_t>(result.places.size() - 1);
    }
    return result;
}

Vec2 contour_normal(const ContourSet& set, const IntervalEndpoint& end, double reach) {
    const Contour& contour = set.contours[end.contour];
    const Plane& plane = set.slices[contour.slice].plane;
    const auto walk = [&](bool forward) {
        std::uint32_t k = forward ? (end.from == end.to ? point_after(contour, end.to) : end.to)
                                  : (end.from == end.to ? point_before(contour, end.from) : end.from);
        double walked = length(set.points[k] - end.at);
        for (std::uint32_t n = 0; n < contour.point_count / 2 && walked < reach; ++n) {
            const std::uint32_t next = forward ? point_after(contour, k) : point_before(contour, k);
            walked += length(set.points[next] - set.points[k]);
            k = next;
        }
        return plane.to_plane(set.points[k]);
    };
    const Vec2 chord = walk(true) - walk(false);
    const double size = length(chord);
    return size > 0 ? Vec2{-chord.y / size, chord.x / size} : Vec2{1, 0};
}

}  // namespace anatomesh
