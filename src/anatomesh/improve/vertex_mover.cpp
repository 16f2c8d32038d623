#include "anatomesh/improve/vertex_mover.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/improve/cell_shape.h"
#include "anatomesh/mesh/quality.h"

namespace anatomesh {

namespace {

constexpr double nearly_flat = 1e-3;  // six volumes in cubes of the longest edge

}  // namespace

bool VertexMover::try_move(std::uint32_t v, Vec3 p) {
    const double before = worst_ratio(v);
    const Shape shape_before = shape(v);
    const Vec3 from = mesh_.points[v];
    mesh_.points[v] = p;
    if (worst_ratio(v) <= std::max(before, max_radius_edge_) && keeps_shape(v, shape_before)) return true;
    mesh_.points[v] = from;
    return false;
}

bool VertexMover::try_better(std::uint32_t v, Vec3 p) {
    const double before = worst_ratio(v);
    const Shape shape_before = shape(v);
    const Vec3 from = mesh_.points[v];
    mesh_.points[v] = p;
    if (worst_ratio(v) < before && keeps_shape(v, shape_before)) return true;
    mesh_.points[v] = from;
    return false;
}

double VertexMover::ratio(std::uint32_t cell) const {
    const Cell& c = mesh_.cells[cell];
    return radius_edge_ratio(mesh_.points[c[0]], mesh_.points[c[1]], mesh_.points[c[2]], mesh_.points[c[3]]);
}

double VertexMover::worst_ratio(std::uint32_t v) const {
    double worst = 0;
    for (const std::uint32_t c : stars_.at(v)) {
        if (mesh_.regions[c] != 0) worst = std::max(worst, ratio(c));
    }
    return worst;
}

double VertexMover::shortest_edge(std::uint32_t v) const {
    double squared = INFINITY;
    for (const std::uint32_t c : stars_.at(v)) {
        for (const std::uint32_t u : mesh_.cells[c]) {
            if (u != v) squared = std::min(squared, squared_length(mesh_.points[u] - mesh_.points[v]));
        }
    }
    return std::sqrt(squared);
}

VertexMover::Shape VertexMover::shape(std::uint32_t v) const {
    Shape worst{INFINITY, INFINITY};
    for (const std::uint32_t cell : stars_.at(v)) {
        const Cell& c = mesh_.cells[cell];
        double longest = 0;
        for (const auto& [i, j] : cell_edges) {
            longest = std::max(longest, squared_length(mesh_.points[c[i]] - mesh_.points[c[j]]));
        }
        const Vec3 p0 = mesh_.points[c[0]], p1 = mesh_.points[c[1]], p2 = mesh_.points[c[2]],
                   p3 = mesh_.points[c[3]];
        worst.flattest =
            std::min(worst.flattest, 6 * signed_volume(p0, p1, p2, p3) / (longest * std::sqrt(longest)));
        if (good_sine_ > 0 && mesh_.regions[cell] != 0)
            worst.sine = std::min(worst.sine, least_sine(p0, p1, p2, p3));
    }
    return worst;
}

bool VertexMover::keeps_shape(std::uint32_t v, const Shape& before) const {
    const Shape now = shape(v);
    if (!(now.flattest >= std::min(before.flattest, nearly_flat)) ||
        !(now.sine >= std::min(before.sine, good_sine_)))
        return false;
    return std::all_of(stars_.at(v).begin(), stars_.at(v).end(), [&](std::uint32_t cell) {
        const Cell& c = mesh_.cells[cell];
        return orient3d(mesh_.points[c[0]], mesh_.points[c[1]], mesh_.points[c[2]], mesh_.points[c[3]]) > 0;
    });
}

}  // namespace anatomesh
