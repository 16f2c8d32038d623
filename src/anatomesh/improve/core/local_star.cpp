#include "anatomesh/improve/core/local_star.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

double LocalStar::worst(Vec3 p, double enough) {
    double least = 1;
    for (std::size_t n = 0; n < faces_.size(); ++n) {
        const Face& f = faces_[n];
        const double sine = least_sine(p, f.a, f.b, f.c);
        const bool fails = f.inside
                               ? !(sine >= enough) || squared_radius_edge(p, f.a, f.b, f.c) > squared_ratio_
                               : !(sine >= flat_);
        if (fails) {
            // The next try is likely to fail here too.
            std::swap(faces_[n], faces_[n / 2]);
            return enough - 1;
        }
        if (f.inside) least = std::min(least, sine);
    }
    return least;
}

double LocalStar::shortest_distance(Vec3 p) const {
    double squared = INFINITY;
    for (const Face& f : faces_) {
        squared =
            std::min({squared, squared_length(f.a - p), squared_length(f.b - p), squared_length(f.c - p)});
    }
    return std::sqrt(squared);
}

// The shortest vector in the convex hull of the gradients of the sines near the worst: along it all of them
// grow.
Vec3 LocalStar::direction(Vec3 p, double value, Vec3 normal, double delta) const {
    constexpr std::size_t most = 10;  // gradients that are combined [gradients; > 0; B]
    std::array<Vec3, most> gradients;
    std::size_t count = 0;
    const double near = value + 0.02 + 0.15 * std::abs(value);
    for (const Face& f : faces_) {
        if (!f.inside) continue;
        const double here = least_sine(p, f.a, f.b, f.c);
        if (here > near || count == most) continue;
        Vec3 g{least_sine(p + Vec3{delta, 0, 0}, f.a, f.b, f.c) - here,
               least_sine(p + Vec3{0, delta, 0}, f.a, f.b, f.c) - here,
               least_sine(p + Vec3{0, 0, delta}, f.a, f.b, f.c) - here};
        g = (1 / delta) * g;
        gradients[count++] = g - dot(g, normal) * normal;
    }
    if (count == 0) return {};
    // Gilbert's algorithm (SIAM J. Control 4, 1966).
    Vec3 shortest = gradients[0];
    for (int step = 0; step < 24; ++step) {
        std::size_t low = 0;
        for (std::size_t n = 1; n < count; ++n) {
            if (dot(gradients[n], shortest) < dot(gradients[low], shortest)) low = n;
        }
        const Vec3 way = gradients[low] - shortest;
        const double along = -dot(shortest, way), squared = squared_length(way);
        if (!(along > 1e-3 * squared_length(shortest))) break;
        shortest += std::min(1.0, along / squared) * way;
    }
    return shortest;
}

}  // namespace anatomesh
