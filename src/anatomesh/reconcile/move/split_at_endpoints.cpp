#include "anatomesh/reconcile/move/split_at_endpoints.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/reconcile/move/reindex_points.h"

namespace anatomesh {

namespace {

// No vertex is put nearer to another one. [mm; > 0; M 2026-11 fetal brain]
constexpr double least_split_mm = 0.1;

struct Split {
    std::uint32_t segment = 0;  // of the graph
    double distance = 0;        // from its lower node
    Vec3 at;
};

std::vector<Split> find_splits(const ContourSet& set, const ContourGraph& graph,
                               std::span<const IntervalEndpoint> places) {
    std::vector<Split> splits;
    for (const IntervalEndpoint& place : places) {
        if (place.from == place.to) continue;
        const std::uint32_t segment = graph.segment_of_point[place.from];
        const Vec3 low = set.points[graph.point_of_node[graph.segments[segment][0]]];
        splits.push_back({segment, length(place.at - low), place.at});
    }
    std::sort(splits.begin(), splits.end(), [](const Split& p, const Split& q) {
        if (p.segment != q.segment) return p.segment < q.segment;
        return p.distance != q.distance ? p.distance < q.distance : lexicographic_less(p.at, q.at);
    });
    return splits;
}

// Returns the splits that keep their distance from the segment's ends and from each other.
std::vector<Split> spaced(const ContourSet& set, const ContourGraph& graph,
                          const std::vector<Split>& splits) {
    std::vector<Split> kept;
    for (const Split& split : splits) {
        const auto& [low, high] = graph.segments[split.segment];
        const bool is_first = kept.empty() || kept.back().segment != split.segment;
        const Vec3 before = is_first ? set.points[graph.point_of_node[low]] : kept.back().at;
        if (length(split.at - before) >= least_split_mm &&
            length(split.at - set.points[graph.point_of_node[high]]) >= least_split_mm)
            kept.push_back(split);
    }
    return kept;
}

std::vector<Vec3> with_splits(const ContourSet& set, const ContourGraph& graph, const Contour& contour,
                              const std::vector<Split>& splits) {
    std::vector<Vec3> points;
    for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
        points.push_back(set.points[k]);
        const std::uint32_t segment = graph.segment_of_point[k];
        const auto [first, last] =
            std::equal_range(splits.begin(), splits.end(), Split{segment, 0, {}},
                             [](const Split& p, const Split& q) { return p.segment < q.segment; });
        const auto begin = static_cast<std::ptrdiff_t>(points.size());
        for (auto split = first; split != last; ++split) points.push_back(split->at);
        if (graph.node_of_point[k] != graph.segments[segment][0])
            std::reverse(points.begin() + begin, points.end());
    }
    return points;
}

}  // namespace

std::size_t split_at_endpoints(ContourSet& set, std::span<const LineComparison> comparisons) {
    std::vector<IntervalEndpoint> places;
    for (const LineComparison& comparison : comparisons) {
        if (comparison.difference_mm == 0) continue;
        for (const auto* ends : {&comparison.endpoints_a, &comparison.endpoints_b})
            places.insert(places.end(), ends->begin(), ends->end());
    }
    return split_at_places(set, places);
}

std::size_t split_at_places(ContourSet& set, std::span<const IntervalEndpoint> places) {
    const ContourGraph graph = make_contour_graph(set);
    const std::vector<Split> splits = spaced(set, graph, find_splits(set, graph, places));
    std::vector<std::vector<Vec3>> fresh(set.contours.size());
    for (const Slice& slice : set.slices) {
        std::vector<PlaneRing> rings;
        const std::uint32_t end = slice.first_contour + slice.contour_count;
        for (std::uint32_t c = slice.first_contour; c < end; ++c) {
            fresh[c] = with_splits(set, graph, set.contours[c], splits);
            PlaneRing ring{set.contours[c].structure, {}};
            for (const Vec3& p : fresh[c]) ring.at.push_back(slice.plane.to_plane(p));
            rings.push_back(std::move(ring));
        }
        if (slice_faults(rings, set.exclusive).empty()) continue;
        for (std::uint32_t c = slice.first_contour; c < end; ++c) {
            const auto old = set.points_of(set.contours[c]);
            fresh[c].assign(old.begin(), old.end());
        }
    }
    const std::size_t before = set.points.size();
    reindex_points(set, fresh);
    return set.points.size() - before;
}

}  // namespace anatomesh
