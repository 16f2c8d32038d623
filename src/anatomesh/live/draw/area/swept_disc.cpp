#include "anatomesh/live/draw/area/swept_disc.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

#include "anatomesh/contour/overlay/arrangement.h"
#include "anatomesh/contour/overlay/boundary_loops.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/live/draw/area/thin_line.h"
#include "anatomesh/live/draw/area/tool_ranges.h"

namespace anatomesh {

namespace {

// A disc has at least so many vertices: a straight sweep is then as wide as the disc within 0.1 %.
// [vertices; multiple of 4; D (2 pi / 60)^2 / 12 < 0.001]
constexpr int least_disc_vertices = 60;
// The outline loses vertices that are within this share of the radius of it. [radii; 0 to 1e-3; D half of 0.1 %]
constexpr double thinning_share = 5e-4;
// So many edges of the path on either side are asked whether they cover a vertex. [edges; > 0; B]
constexpr std::ptrdiff_t looked_at_edges = 24;
// A vertex that is deeper within the sweep than this is in its interior. [mm; > 0; D rounding within 1e7 mm]
constexpr double interior_mm = 1e-7;

// A regular polygon with the area of a disc, counter-clockwise.
struct Disc {
    Disc(double radius, double tolerance) {
        // The polygon of n vertices and the same area leaves the circle by radius * step^2 / 12 at most.
        const double most_step = std::sqrt(12 * tolerance / radius);
        const int quarter =
            std::max(least_disc_vertices / 4, static_cast<int>(std::ceil(std::numbers::pi / 2 / most_step)));
        count = 4 * quarter;
        step = 2 * std::numbers::pi / count;
        outer = radius * std::sqrt(step / std::sin(step));
        inner = outer * std::cos(step / 2);
        for (int k = 0; k < count; ++k) {
            const double angle = step * (k + phase);
            vertices.push_back(outer * Vec2{std::cos(angle), std::sin(angle)});
        }
    }

    // The vertex that is farthest to the right of this direction.
    int support(Vec2 direction) const {
        const double angle = std::atan2(-direction.x, direction.y);
        const int k = static_cast<int>(std::lround(angle / step - phase));
        return (k % count + count) % count;
    }

    // Whether the vector from the centre ends in the disc, deeper than interior_mm.
    bool has_deep(Vec2 v) const {
        const double square = squared_length(v);
        if (square >= outer * outer) return false;
        const double angle = std::atan2(v.y, v.x) / step - phase;
        const double normal = (std::floor(angle) + 0.5 + phase) * step;
        return dot(v, {std::cos(normal), std::sin(normal)}) < inner - interior_mm;
    }

    // The first vertex's direction in steps: no edge is parallel to a direction that pixels or a hand prefer.
    // [steps; 0 to 1; D a choice, measurement not recorded]
    static constexpr double phase = 0.2764;

    int count = 0;
    double step = 0, outer = 0, inner = 0;
    std::vector<Vec2> vertices;
};

class Sweep {
  public:
    Sweep(std::vector<Vec2> path, const Disc& disc, const Plane& plane)
        : path_(std::move(path)), disc_(disc), plane_(plane) {}

    std::optional<std::vector<std::vector<Vec2>>> run() {
        if (path_.size() == 1) return std::vector<std::vector<Vec2>>{shifted_disc()};
        convolve();
        const std::vector<Ring> tour{ring_of(with_chords(), plane_)};
        const std::optional<Arrangement> graph = arrange(tour, plane_, most_drawn_edges);
        if (!graph) return std::nullopt;
        return boundary(*graph);
    }

  private:
    std::vector<Vec2> shifted_disc() const {
        std::vector<Vec2> polygon;
        for (const Vec2 d : disc_.vertices) polygon.push_back(path_[0] + d);
        return polygon;
    }

    void push(std::size_t place, int vertex) {
        const int k = (vertex % disc_.count + disc_.count) % disc_.count;
        tour_.push_back(path_[place] + disc_.vertices[static_cast<std::size_t>(k)]);
        place_.push_back(place);
    }

    // The convolution of the path, run there and back, with the disc.
    void convolve() {
        const std::size_t last = path_.size() - 1;
        for (std::size_t i = 0; i < last; ++i) add_edge(i, i + 1, i + 1 < last ? i + 2 : i);
        for (std::size_t i = last; i > 0; --i) add_edge(i, i - 1, i > 1 ? i - 2 : i);
    }

    // Adds the edge from a to b, and the arc at b until the edge towards c begins.
    void add_edge(std::size_t a, std::size_t b, std::size_t c) {
        const Vec2 along = path_[b] - path_[a], next = path_[c] - path_[b];
        const int from = disc_.support(along), to = disc_.support(next);
        push(a, from);
        push(b, from);
        // The turn in whole steps; straight back is a turn to the left.
        const double side = cross(along, next);
        const double turn =
            side == 0 && dot(along, next) < 0 ? std::numbers::pi : std::atan2(side, dot(along, next));
        const auto rounds = std::lround((turn / disc_.step - (to - from)) / disc_.count);
        const int steps = to - from + disc_.count * static_cast<int>(rounds);
        const int sign = steps < 0 ? -1 : 1;
        for (int k = 1; k < std::abs(steps); ++k) push(b, from + sign * k);
    }

    // Whether the sum of an edge of the path and the disc's inner circle has the point in its interior.
    bool covers(std::size_t edge, Vec2 p) const {
        const Vec2 a = path_[edge], along = path_[edge + 1] - a, to = p - a;
        const double square = dot(along, along);
        const double t = std::clamp(dot(to, along) / square, 0.0, 1.0);
        const double within = disc_.inner - interior_mm;
        return within > 0 && squared_length(to - t * along) < within * within;
    }

    // How far the tour stays within the sum of an edge near its vertex k, as the last vertex that does; k for nowhere.
    std::size_t end_of_chord(std::size_t k) const {
        const auto edges = static_cast<std::ptrdiff_t>(path_.size()) - 1;
        const auto place = static_cast<std::ptrdiff_t>(place_[k]);
        std::size_t farthest = k;
        for (std::ptrdiff_t distance = 1; distance <= looked_at_edges; ++distance) {
            for (const std::ptrdiff_t edge : {place - 1 - distance, place + distance}) {
                if (edge < 0 || edge >= edges) continue;
                const auto e = static_cast<std::size_t>(edge);
                if (farthest + 1 < tour_.size() && covers(e, tour_[k]) && covers(e, tour_[farthest + 1])) {
                    std::size_t end = k + 1;
                    while (end < tour_.size() && covers(e, tour_[end])) ++end;
                    farthest = std::max(farthest, end - 1);
                }
            }
        }
        return farthest;
    }

    // The tour with chords for its stretches within one convex sum. Both are in it, so no winding number outside
    // changes.
    std::vector<Vec2> with_chords() const {
        std::vector<Vec2> kept;
        for (std::size_t k = 0; k < tour_.size();) {
            kept.push_back(tour_[k]);
            k = std::max(k + 1, end_of_chord(k));
        }
        return kept;
    }

    // The rings between faces inside and outside, the outer one first.
    std::vector<std::vector<Vec2>> boundary(const Arrangement& graph) const {
        const std::vector<char> inside = faces_inside(graph);
        std::vector<BoundaryEdge> edges;
        for (const Arrangement::Edge& edge : graph.edges) {
            if (inside[edge.left] == inside[edge.right]) continue;
            edges.push_back(inside[edge.left] ? BoundaryEdge{edge.a, edge.b} : BoundaryEdge{edge.b, edge.a});
        }
        std::vector<std::vector<Vec2>> rings;
        for (const std::vector<std::uint32_t>& loop : boundary_loops(graph.at, edges)) {
            std::vector<Vec2> polygon;
            for (const std::uint32_t edge : loop) polygon.push_back(graph.at[edges[edge].from]);
            if (2 * std::abs(signed_area(polygon)) <= sliver_width_mm * perimeter(polygon)) continue;
            rings.push_back(std::move(polygon));
        }
        std::stable_partition(rings.begin(), rings.end(),
                              [](const std::vector<Vec2>& polygon) { return signed_area(polygon) > 0; });
        return rings;
    }

    // Whether each face lies in the sweep. What winds around a face shows that it does. Where nothing does, the face is
    // outside, or chords left it in the interior: then its edges lie deep in the sweep. The longer part decides, because
    // rounding may open a crack from outside into the interior.
    std::vector<char> faces_inside(const Arrangement& graph) const {
        std::vector<char> inside;
        for (const Winding& winding : graph.windings) {
            inside.push_back(!winding.empty() && winding.front().turns > 0);
        }
        const std::uint32_t unbounded = unbounded_face(graph);
        std::vector<double> deep(inside.size(),
                                 0);  // per face: the length of its edges deep in the sweep less the rest
        for (const Arrangement::Edge& edge : graph.edges) {
            const auto is_known = [&](std::uint32_t face) { return inside[face] || face == unbounded; };
            if (is_known(edge.left) && is_known(edge.right)) continue;
            const Vec2 a = graph.at[edge.a], b = graph.at[edge.b];
            const double signed_length = is_interior(0.5 * (a + b)) ? length(b - a) : -length(b - a);
            for (const std::uint32_t face : {edge.left, edge.right}) deep[face] += signed_length;
        }
        for (std::uint32_t face = 0; face < inside.size(); ++face) {
            if (!inside[face] && face != unbounded && deep[face] > 0) inside[face] = 1;
        }
        return inside;
    }

    // The face left of the last edge, counter-clockwise, of the smallest vertex, from which all edges go right.
    static std::uint32_t unbounded_face(const Arrangement& graph) {
        const Arrangement::Edge* last = &graph.edges.front();
        for (const Arrangement::Edge& edge : graph.edges) {
            const bool is_smaller = lexicographic_less(graph.at[edge.a], graph.at[last->a]);
            const bool is_later =
                edge.a == last->a && orient2d(graph.at[edge.a], graph.at[last->b], graph.at[edge.b]) > 0;
            if (is_smaller || is_later) last = &edge;
        }
        return last->left;
    }

    bool is_interior(Vec2 p) const {
        for (std::size_t edge = 0; edge + 1 < path_.size(); ++edge) {
            if (is_within_sum(path_[edge], path_[edge + 1], p)) return true;
        }
        return false;
    }

    // Whether p lies deep in the sum of the segment ab and the disc: around an end, or beside the segment.
    bool is_within_sum(Vec2 a, Vec2 b, Vec2 p) const {
        if (disc_.has_deep(p - a) || disc_.has_deep(p - b)) return true;
        const double whole = length(b - a);
        const Vec2 along = (1 / whole) * (b - a);
        const double side = cross(p - a, along);  // to the right
        if (std::abs(side) >= disc_.outer) return false;
        const Vec2 direction = side < 0 ? -1 * along : along;
        const Vec2 farthest = disc_.vertices[static_cast<std::size_t>(disc_.support(direction))];
        const double reach = cross(farthest, direction), share = std::abs(side) / reach;
        if (std::abs(side) > reach - interior_mm) return false;
        const double t = dot(p - share * farthest - a, along);
        return t > 0 && t < whole;
    }

    const std::vector<Vec2> path_;
    const Disc& disc_;
    const Plane& plane_;
    std::vector<Vec2> tour_;
    std::vector<std::size_t> place_;  // per vertex of the tour: the point of the path it belongs to
};

}  // namespace

Result<std::vector<Ring>> swept_disc(std::span<const Vec2> path, const Plane& plane,
                                     const SweptDiscOptions& options) {
    assert(!path.empty());
    ANATOMESH_CHECK_STATUS(check_points(path, "the path"));
    ANATOMESH_CHECK_STATUS(check_option(options.radius_mm, least_radius_mm, most_radius_mm, "radius_mm"));
    ANATOMESH_CHECK_STATUS(
        check_option(options.tolerance_mm, least_tolerance_mm, most_tolerance_mm, "tolerance_mm"));
    const Disc disc(options.radius_mm, options.tolerance_mm / 4);
    const auto polygons = Sweep(thin_path(path, options.tolerance_mm / 2), disc, plane).run();
    if (!polygons) return crosses_too_often();
    std::vector<Ring> rings;
    const double thinning = std::min(options.tolerance_mm / 4, thinning_share * options.radius_mm);
    for (const std::vector<Vec2>& polygon : thin_polygons(*polygons, thinning)) {
        rings.push_back(ring_of(polygon, plane));
    }
    return rings;
}

}  // namespace anatomesh
