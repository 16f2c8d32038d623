#include "anatomesh/mesh/shape/quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "anatomesh/base/instruction_sets.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

namespace {

// Six times the volume, and the numerator of the circumcenter relative to a:
// circumcenter = a + offset / (2 volume6).
struct Circumsphere {
    Vec3 offset;
    double volume6;
};

[[gnu::always_inline]] inline Circumsphere circumsphere(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const Vec3 ab = b - a, ac = c - a, ad = d - a;
    const Vec3 bc = cross(ab, ac);
    const Vec3 offset =
        squared_length(ad) * bc + squared_length(ac) * cross(ad, ab) + squared_length(ab) * cross(ac, ad);
    return {offset, dot(bc, ad)};
}

// Sine and cosine, times the same positive number, of the dihedral angle at each edge of cell_edges: with
// outward normals n_k of twice the area, dot(n_k, n_l) = -|n_k| |n_l| cos and |n_k| |n_l| sin = 6 volume
// |edge|.
struct ScaledAngles {
    std::array<double, 6> sine, cosine;
};

ScaledAngles scaled_angles(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const std::array<Vec3, 4> p{a, b, c, d};
    std::array<Vec3, 4> normal;
    for (std::size_t i = 0; i < 4; ++i) {
        const auto& f = facet_vertices[i];
        const Vec3 origin = p[static_cast<std::size_t>(f[0])];
        normal[i] =
            cross(p[static_cast<std::size_t>(f[1])] - origin, p[static_cast<std::size_t>(f[2])] - origin);
    }
    const double volume6 = std::abs(dot(normal[3], a - d));
    ScaledAngles angles;
    for (std::size_t e = 0; e < 6; ++e) {
        const auto i = static_cast<std::size_t>(cell_edges[e][0]),
                   j = static_cast<std::size_t>(cell_edges[e][1]);
        // The two facets at an edge are opposite the other two vertices: those of the edge 5 - e.
        const auto k = static_cast<std::size_t>(cell_edges[5 - e][0]);
        const auto l = static_cast<std::size_t>(cell_edges[5 - e][1]);
        angles.sine[e] = volume6 * length(p[j] - p[i]);
        angles.cosine[e] = -dot(normal[k], normal[l]);
    }
    return angles;
}

}  // namespace

ANATOMESH_CLONES double radius_edge_ratio(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const Circumsphere sphere = circumsphere(a, b, c, d);
    const double shortest2 = std::min({squared_length(b - a), squared_length(c - a), squared_length(d - a),
                                       squared_length(c - b), squared_length(d - b), squared_length(d - c)});
    if (sphere.volume6 == 0.0 || shortest2 == 0.0) return std::numeric_limits<double>::infinity();
    return length(sphere.offset) / (2.0 * std::abs(sphere.volume6) * std::sqrt(shortest2));
}

DihedralRange dihedral_range(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const ScaledAngles scaled = scaled_angles(a, b, c, d);
    // Sines are not negative, so the angle grows as its cotangent falls: compare by cross-multiplication.
    std::size_t smallest = 0, largest = 0;
    for (std::size_t e = 1; e < 6; ++e) {
        if (scaled.cosine[e] * scaled.sine[smallest] > scaled.cosine[smallest] * scaled.sine[e]) smallest = e;
        if (scaled.cosine[e] * scaled.sine[largest] < scaled.cosine[largest] * scaled.sine[e]) largest = e;
    }
    const auto angle = [&](std::size_t e) {
        return degrees_per_radian * std::atan2(scaled.sine[e], scaled.cosine[e]);
    };
    if (scaled.sine[0] == 0.0) return {0.0, 180.0};
    return {angle(smallest), angle(largest)};
}

double signed_volume(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    return dot(cross(b - a, c - a), d - a) / 6.0;
}

Vec3 circumcenter(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const Circumsphere sphere = circumsphere(a, b, c, d);
    return a + (1.0 / (2.0 * sphere.volume6)) * sphere.offset;
}

}  // namespace anatomesh
