#include "anatomesh/measure/hausdorff.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/point_triangle.h"

namespace anatomesh {

namespace {

double squared_distance(const Box3& box, Vec3 p) {
    const double x = std::max({box.low.x - p.x, 0.0, p.x - box.high.x});
    const double y = std::max({box.low.y - p.y, 0.0, p.y - box.high.y});
    const double z = std::max({box.low.z - p.z, 0.0, p.z - box.high.z});
    return x * x + y * y + z * z;
}

double twice_area(const SurfaceMesh& surface, const Triangle& f) {
    const Vec3 a = surface.points[f[0]];
    return length(cross(surface.points[f[1]] - a, surface.points[f[2]] - a));
}

Status check_surface(const SurfaceMesh& surface, const char* which) {
    const Place place{{}, {}, {}, {}, which};
    if (surface.triangles.empty()) {
        return Error{ErrorKind::input, "E-MEA-001", "the surface has no triangle", place,
                     "give a model or a surface with at least one facet"};
    }
    double area = 0;
    for (const Triangle& f : surface.triangles) {
        for (const std::uint32_t v : f) {
            const Vec3 p = surface.points[v];
            if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
            return Error{ErrorKind::input, "E-MEA-002", "a coordinate of the surface is not finite", place,
                         "repair point " + std::to_string(v)};
        }
        area += twice_area(surface, f);
    }
    if (!(area > 0) || !std::isfinite(area)) {
        return Error{ErrorKind::input, "E-MEA-003", "the surface has no area", place,
                     "give a surface whose triangles are not all degenerate"};
    }
    return Nothing{};
}

// Vertices that triangles use, in their order.
std::vector<Vec3> used_vertices(const SurfaceMesh& surface) {
    std::vector<std::uint8_t> used(surface.points.size(), 0);
    for (const Triangle& f : surface.triangles) {
        for (const std::uint32_t v : f) used[v] = 1;
    }
    std::vector<Vec3> vertices;
    for (std::size_t v = 0; v < used.size(); ++v) {
        if (used[v]) vertices.push_back(surface.points[v]);
    }
    return vertices;
}

std::vector<double> distances(const std::vector<Vec3>& points, const ClosestPoint& target,
                              RunContext& context) {
    std::vector<double> found(points.size());
    parallel_for(points.size(), 1024, context.threads, [&](std::size_t begin, std::size_t end) {
        if (context.cancelled()) return;
        for (std::size_t i = begin; i < end; ++i) found[i] = target.distance(points[i]);
    });
    return found;
}

// Sample distances (sorted on return) and the smallest and largest at vertices.
DistanceStats stats_of(std::vector<double>& samples, std::pair<double, double> vertex_range) {
    std::sort(samples.begin(), samples.end());
    double sum = 0, sum_of_squares = 0;
    for (const double d : samples) {
        sum += d;
        sum_of_squares += d * d;
    }
    const auto count = static_cast<double>(samples.size());
    const auto rank = static_cast<std::size_t>(std::ceil(0.95 * count)) - 1;
    return {std::min(samples.front(), vertex_range.first), sum / count, std::sqrt(sum_of_squares / count),
            samples[rank], std::max(samples.back(), vertex_range.second)};
}

struct OneWay {
    std::vector<double> samples;
    std::pair<double, double> vertex_range;
};

OneWay one_way(const SurfaceMesh& from, const SurfaceMesh& to, std::uint64_t count, RunContext& context) {
    const ClosestPoint target(to);
    OneWay way{distances(area_samples(from, count), target, context), {}};
    const std::vector<double> at_vertices = distances(used_vertices(from), target, context);
    const auto [least, most] = std::minmax_element(at_vertices.begin(), at_vertices.end());
    way.vertex_range = {*least, *most};
    return way;
}

}  // namespace

ClosestPoint::ClosestPoint(const SurfaceMesh& surface)
    : surface_(surface), tree_(make_box_tree(surface.points, surface.triangles)) {
    assert(!surface.triangles.empty());
}

double ClosestPoint::distance(Vec3 p) const {
    // Depth first, the nearer child on top. The tree halves its triangles at every level: 32 levels at most.
    struct Visit {
        double squared;
        std::uint32_t node;
    };
    std::array<Visit, 80> stack;
    std::size_t depth = 0;
    stack[depth++] = {squared_distance(tree_.nodes[0].box, p), 0};
    double best = std::numeric_limits<double>::infinity();
    while (depth > 0) {
        const Visit visit = stack[--depth];
        if (visit.squared >= best) continue;
        const BoxTree::Node& node = tree_.nodes[visit.node];
        if (node.count == 0) {
            Visit near{squared_distance(tree_.nodes[node.first].box, p), node.first};
            Visit far{squared_distance(tree_.nodes[node.first + 1].box, p), node.first + 1};
            if (far.squared < near.squared) std::swap(near, far);
            stack[depth++] = far;
            stack[depth++] = near;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const Triangle& f = surface_.triangles[tree_.order[i]];
            best =
                std::min(best, point_triangle_squared_distance(p, surface_.points[f[0]],
                                                               surface_.points[f[1]], surface_.points[f[2]]));
        }
    }
    return std::sqrt(best);
}

std::vector<Vec3> area_samples(const SurfaceMesh& surface, std::uint64_t count) {
    double total = 0;
    for (const Triangle& f : surface.triangles) total += twice_area(surface, f);
    assert(total > 0);
    // R2 takes multiples of 1/g and 1/g^2 modulo 1, which fill a square evenly. [1; root of g^3 = g + 1; D]
    constexpr double g = 1.32471795724474602596;
    std::vector<Vec3> samples;
    samples.reserve(count);
    double passed = 0;  // area of the triangles before the current one
    std::size_t t = 0;
    double own = twice_area(surface, surface.triangles[0]);
    for (std::uint64_t k = 0; k < count; ++k) {
        const double wanted = (static_cast<double>(k) + 0.5) / static_cast<double>(count) * total;
        while (passed + own < wanted && t + 1 < surface.triangles.size()) {
            passed += own;
            own = twice_area(surface, surface.triangles[++t]);
        }
        double whole;
        const double u = std::modf(0.5 + static_cast<double>(k + 1) / g, &whole);
        const double v = std::modf(0.5 + static_cast<double>(k + 1) / (g * g), &whole);
        const double s = std::sqrt(u);
        const Triangle& f = surface.triangles[t];
        samples.push_back((1 - s) * surface.points[f[0]] + (s * (1 - v)) * surface.points[f[1]] +
                          (s * v) * surface.points[f[2]]);
    }
    return samples;
}

Result<SurfaceDistance> surface_distance(const SurfaceMesh& a, const SurfaceMesh& b,
                                         const SurfaceDistanceOptions& options, RunContext& context) {
    if (options.samples < 1 || options.samples > 100'000'000) {
        return Error{ErrorKind::usage,
                     "E-MEA-004",
                     "the number of samples must be from 1 to 100000000",
                     {{}, {}, {}, {}, std::to_string(options.samples)},
                     ""};
    }
    ANATOMESH_CHECK_STATUS(check_surface(a, "first surface"));
    ANATOMESH_CHECK_STATUS(check_surface(b, "second surface"));
    OneWay forth = one_way(a, b, options.samples, context);
    OneWay back = one_way(b, a, options.samples, context);
    if (context.cancelled()) return cancelled_error();

    SurfaceDistance distance;
    distance.samples_a = forth.samples.size();
    distance.samples_b = back.samples.size();
    distance.a_to_b = stats_of(forth.samples, forth.vertex_range);
    distance.b_to_a = stats_of(back.samples, back.vertex_range);
    std::vector<double> all = std::move(forth.samples);
    all.insert(all.end(), back.samples.begin(), back.samples.end());
    distance.both = stats_of(all, {std::min(forth.vertex_range.first, back.vertex_range.first),
                                   std::max(forth.vertex_range.second, back.vertex_range.second)});
    return distance;
}

}  // namespace anatomesh
