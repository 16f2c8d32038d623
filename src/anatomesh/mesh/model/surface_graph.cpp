#include "anatomesh/mesh/model/surface_graph.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/geom/numbers.h"

namespace anatomesh {

SurfaceGraph::SurfaceGraph(std::span<const Vec3> points, std::span<const Triangle> triangles)
    : points_(points), start_(points.size() + 1, 0) {
    // Both ends of every side; neighbours come once for each triangle at their edge.
    for (const Triangle& f : triangles) {
        for (const std::uint32_t v : f) start_[v + 1] += 2;
    }
    for (std::size_t v = 0; v < points.size(); ++v) start_[v + 1] += start_[v];
    neighbors_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (const Triangle& f : triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            neighbors_[next[f[i]]++] = f[(i + 1) % 3];
            neighbors_[next[f[i]]++] = f[(i + 2) % 3];
        }
    }
}

bool SurfaceGraph::chain(std::uint32_t a, std::uint32_t b) const {
    const Vec3 start = points_[a], way = points_[b] - start;
    const double whole = squared_length(way);
    const double size = std::max({std::abs(start.x), std::abs(start.y), std::abs(start.z)});
    const double tolerance = on_segment_share * std::sqrt(whole) + 1e-12 * size;
    std::uint32_t current = a;
    double reached = 0;
    while (current != b) {
        std::uint32_t next = no_cell;
        double next_reached = whole;
        for (const std::uint32_t v : neighbors(current)) {
            const Vec3 offset = points_[v] - start;
            const double along = dot(offset, way);
            if (along <= reached || along > next_reached) continue;
            if (length(cross(offset, way)) > tolerance * std::sqrt(whole)) continue;
            next = v;
            next_reached = along;
        }
        if (next == no_cell) return false;
        current = next;
        reached = next_reached;
    }
    return true;
}

}  // namespace anatomesh
