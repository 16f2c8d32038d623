#include "anatomesh/contour/simplify/simplify.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/model/area_change.h"
#include "anatomesh/contour/simplify/chains.h"

namespace anatomesh {

namespace {

// Kept vertices should keep this share of their spacing from foreign segments. [1; 0 to 1; M 2026-11, set not recorded]
constexpr double clearance_share = 0.3;

// The contours of one slice as a network: equal points are one vertex, equal segments one edge.
class SliceNetwork {
  public:
    SliceNetwork(const ContourSet& set, const Slice& slice, double crowded) : crowded_(crowded) {
        unite_points(set, slice);
        collect_edges(set, slice);
        walk_chains();
    }

    const ChainNetwork& network() const { return network_; }

    // The vertex of the slice's n-th contour point, in the order of the set's points.
    std::uint32_t vertex_of(std::size_t n) const { return vertex_of_[n]; }

  private:
    void unite_points(const ContourSet& set, const Slice& slice) {
        std::vector<Vec3> points;
        for (const Contour& contour : set.contours_of(slice)) {
            const std::span<const Vec3> of = set.points_of(contour);
            points.insert(points.end(), of.begin(), of.end());
        }
        std::vector<std::uint32_t> order(points.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return lexicographic_less(points[a], points[b]); });
        vertex_of_.resize(points.size());
        for (std::size_t n = 0; n < order.size(); ++n) {
            if (n == 0 || points[order[n]] != points[order[n - 1]]) {
                network_.points.push_back(slice.plane.to_plane(points[order[n]]));
            }
            vertex_of_[order[n]] = static_cast<std::uint32_t>(network_.points.size()) - 1;
        }
    }

    // Every edge in both directions, sorted: the neighbours of a vertex lie side by side.
    void collect_edges(const ContourSet& set, const Slice& slice) {
        std::size_t first = 0;
        for (const Contour& contour : set.contours_of(slice)) {
            for (std::size_t n = 0; n < contour.point_count; ++n) {
                const std::uint32_t a = vertex_of_[first + n];
                const std::uint32_t b = vertex_of_[first + (n + 1) % contour.point_count];
                if (a == b) continue;
                edges_.push_back({a, b});
                edges_.push_back({b, a});
            }
            first += contour.point_count;
        }
        std::sort(edges_.begin(), edges_.end());
        edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
        first_edge_.assign(network_.points.size() + 1, 0);
        for (const Edge& edge : edges_) ++first_edge_[edge.first + 1];
        std::partial_sum(first_edge_.begin(), first_edge_.end(), first_edge_.begin());
        walked_.assign(edges_.size(), 0);
    }

    // A vertex is kept where something begins, ends or parts, and where it is not crowded if only crowded ones may go.
    bool is_junction(std::uint32_t vertex) const {
        const std::size_t first = first_edge_[vertex];
        if (first_edge_[vertex + 1] - first != 2) return true;
        return crowded_ > 0 && std::min(length_of(first), length_of(first + 1)) >= crowded_;
    }

    double length_of(std::size_t edge) const {
        return length(network_.points[edges_[edge].second] - network_.points[edges_[edge].first]);
    }

    void walk_chains() {
        for (const bool from_junctions : {true, false}) {
            for (std::uint32_t vertex = 0; vertex < network_.points.size(); ++vertex) {
                if (is_junction(vertex) != from_junctions) continue;
                for (std::size_t edge = first_edge_[vertex]; edge < first_edge_[vertex + 1]; ++edge) {
                    if (!walked_[edge]) walk(edge);
                }
            }
        }
    }

    // Walks along the edge and on, until a junction or back to the start.
    void walk(std::size_t edge) {
        const std::uint32_t start = edges_[edge].first;
        network_.chain_points.push_back(start);
        while (true) {
            const auto [from, to] = edges_[edge];
            walked_[edge] = 1;
            const auto back = std::lower_bound(edges_.begin(), edges_.end(), Edge{to, from});
            walked_[static_cast<std::size_t>(back - edges_.begin())] = 1;
            network_.chain_points.push_back(to);
            if (to == start || is_junction(to)) break;
            edge = first_edge_[to] + (edges_[first_edge_[to]].second == from ? 1 : 0);
        }
        network_.close_chain(is_junction(start));
    }

    using Edge = std::pair<std::uint32_t, std::uint32_t>;

    const double crowded_;
    ChainNetwork network_;
    std::vector<std::uint32_t> vertex_of_;
    std::vector<Edge> edges_;
    std::vector<std::size_t> first_edge_;  // per vertex
    std::vector<std::uint8_t> walked_;     // per edge
};

// The contours of one simplified slice, in their final order.
struct ThinSlice {
    std::vector<Contour> contours;  // first_point counts in `points`
    std::vector<Vec3> points;
    std::vector<AreaChange> changes;
    double max_distance = 0;
};

ThinSlice simplify_slice(const ContourSet& set, const Slice& slice, const SimplifyOptions& options) {
    const SliceNetwork slice_network(set, slice, options.crowded_mm);
    const double spacing = options.min_vertex_spacing_mm;
    const ThinResult thin =
        thin_chains(slice_network.network(), {options.epsilon_mm, spacing, clearance_share * spacing});

    ThinSlice result;
    result.max_distance = thin.max_distance;
    std::size_t n = 0;
    for (const Contour& contour : set.contours_of(slice)) {
        Contour kept = contour;
        kept.first_point = static_cast<std::uint32_t>(result.points.size());
        for (const Vec3& point : set.points_of(contour)) {
            if (thin.kept[slice_network.vertex_of(n++)]) result.points.push_back(point);
        }
        kept.point_count = static_cast<std::uint32_t>(result.points.size()) - kept.first_point;
        result.changes.push_back(area_change(contour.structure, set.points_of(contour),
                                             std::span(result.points).subspan(kept.first_point),
                                             slice.plane.normal));
        const auto begin = result.points.begin() + kept.first_point;
        std::rotate(begin, std::min_element(begin, result.points.end(), LexicographicLess{}),
                    result.points.end());
        result.contours.push_back(kept);
    }
    std::stable_sort(result.contours.begin(), result.contours.end(), [&](const Contour& a, const Contour& b) {
        if (a.structure != b.structure) return a.structure < b.structure;
        return lexicographic_less(result.points[a.first_point], result.points[b.first_point]);
    });
    return result;
}

}  // namespace

Result<SimplifyResult> simplify_contours(const ContourSet& set, const SimplifyOptions& options,
                                         RunContext& context) {
    assert(options.epsilon_mm >= 0 && options.min_vertex_spacing_mm >= 0);
    if (options.epsilon_mm == 0) return SimplifyResult{set, {set.points.size(), set.points.size(), 0}};

    std::vector<ThinSlice> slices(set.slices.size());
    parallel_for(slices.size(), 1, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end && !context.cancelled(); ++s) {
            slices[s] = simplify_slice(set, set.slices[s], options);
        }
    });
    if (context.cancelled()) return cancelled_error();

    SimplifyResult result{set, {}};
    ContourSet& kept = result.kept;
    kept.points.clear();
    std::vector<AreaChange> changes;
    for (std::size_t s = 0; s < slices.size(); ++s) {
        std::uint32_t next = set.slices[s].first_contour;
        for (const Contour& contour : slices[s].contours) {
            kept.contours[next] = contour;
            kept.contours[next++].first_point = static_cast<std::uint32_t>(kept.points.size());
            const auto first = slices[s].points.begin() + contour.first_point;
            kept.points.insert(kept.points.end(), first, first + contour.point_count);
        }
        changes.insert(changes.end(), slices[s].changes.begin(), slices[s].changes.end());
        result.stats.max_distance_mm = std::max(result.stats.max_distance_mm, slices[s].max_distance);
    }
    warn_of_area_changes(changes, set.structures, set.source, context);
    result.stats.points_in = set.points.size();
    result.stats.points_kept = kept.points.size();
    return result;
}

}  // namespace anatomesh
