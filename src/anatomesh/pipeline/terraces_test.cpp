// Terraces: a model of slices must be about as smooth as a mesh made on the solid itself.
#include <gtest/gtest.h>

#include <array>
#include <map>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh::terraces_test {
namespace {

using namespace fixtures;

struct Turn {
    Vec3 x, y, z;
    Vec3 operator()(Vec3 p) const { return p.x * x + p.y * y + p.z * z; }
    Vec3 back(Vec3 p) const { return {dot(p, x), dot(p, y), dot(p, z)}; }
};

// x = turned (axes * unit ball), and its slices.
struct Ellipsoid {
    Vec3 axes{32, 24, 18};
    Vec3 along{1, 0.4, 0.6};  // its first axis; it leans against all axes
    double gap = 3, spacing = 2.5;

    Turn turn() const {
        const Vec3 x = normalized(along), y = normalized(cross({0, 0, 1}, x));
        return {x, y, cross(x, y)};
    }
};

// The ellipse in which the plane at z cuts the ellipsoid, its points about as far apart as they should be;
// empty where it does not.
Polygon section(const Ellipsoid& solid, double z) {
    const Turn turned = solid.turn();
    const Vec3 axes = solid.axes;
    // |A p|^2 = 1 with A = diag(1 / axes) * turn^T, restricted to the plane: a quadratic form in x and y.
    const auto unit = [&](Vec3 p) {
        const Vec3 q = turned.back(p);
        return Vec3{q.x / axes.x, q.y / axes.y, q.z / axes.z};
    };
    const Vec3 u = unit({1, 0, 0}), v = unit({0, 1, 0}), w = unit({0, 0, z});
    const double a = dot(u, u), b = dot(u, v), c = dot(v, v), determinant = a * c - b * b;
    const Vec2 centre{-(c * dot(u, w) - b * dot(v, w)) / determinant,
                      -(a * dot(v, w) - b * dot(u, w)) / determinant};
    const double rest = 1 - squared_length(w + centre.x * u + centre.y * v);
    if (!(rest > 0.02)) return {};
    // The square root of the inverse of (a b; b c), by Cholesky.
    const double l = std::sqrt(a), m = b / l, n = std::sqrt(c - m * m);
    const int corners =
        std::max(8, static_cast<int>(2 * pi * std::sqrt(rest / std::sqrt(determinant)) / solid.spacing));
    Polygon polygon;
    for (int k = 0; k < corners; ++k) {
        const double t = 2 * pi * k / corners, s = std::sqrt(rest) * std::sin(t) / n;
        polygon.push_back(centre + Vec2{std::sqrt(rest) * std::cos(t) / l - m * s / l, s});
    }
    return polygon;
}

struct Smoothness {
    double angle = 0, edge = 0;  // mean angle between neighbouring facets, degrees; mean edge, mm
};

// Of the edges between vertices that `counts` accepts.
template <class Counts>
Smoothness smoothness(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
                      Counts counts) {
    std::map<std::array<std::uint32_t, 2>, Vec3> waiting;
    Smoothness mean;
    double edges = 0;
    for (const Triangle& t : triangles) {
        const Vec3 normal = normalized(cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]));
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            const std::array<std::uint32_t, 2> edge{std::min(a, b), std::max(a, b)};
            const auto [other, is_first] = waiting.try_emplace(edge, normal);
            if (is_first || !counts(points[a]) || !counts(points[b])) continue;
            mean.angle +=
                std::atan2(length(cross(normal, other->second)), dot(normal, other->second)) * 180 / pi;
            mean.edge += length(points[a] - points[b]);
            ++edges;
        }
    }
    mean.angle /= edges;
    mean.edge /= edges;
    return mean;
}

// The ellipsoid meshed directly: every facet of an icosahedron cut into n^2, the vertices put onto the solid.
Smoothness direct(const Ellipsoid& solid, int n) {
    const double g = 0.5 * (1 + std::sqrt(5.0));
    const std::array<Vec3, 12> corners{Vec3{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                       {0, -1, g},     {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                       {g, 0, -1},     {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    const std::array<std::array<int, 3>, 20> facets{
        {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
         {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
         {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
    std::vector<Vec3> points;
    std::vector<Triangle> triangles;
    const Turn turned = solid.turn();
    const Vec3 axes = solid.axes;
    const auto less = [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); };
    std::map<Vec3, std::uint32_t, decltype(less)> known(less);
    for (const auto& facet : facets) {
        const auto vertex = [&](int i, int j) {
            const Vec3 sum = static_cast<double>(n - i - j) * corners[facet[0]] +
                             static_cast<double>(i) * corners[facet[1]] +
                             static_cast<double>(j) * corners[facet[2]];
            const auto rounded = [](double x) { return std::round(x * 1e6) / 1e6 + 0.0; };
            const auto [entry, is_new] = known.try_emplace({rounded(sum.x), rounded(sum.y), rounded(sum.z)},
                                                           static_cast<std::uint32_t>(points.size()));
            if (is_new) {
                const Vec3 q = normalized(sum);
                points.push_back(turned({axes.x * q.x, axes.y * q.y, axes.z * q.z}));
            }
            return entry->second;
        };
        for (int i = 0; i < n; ++i) {
            for (int j = 0; i + j < n; ++j) {
                triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)});
                if (i + j + 2 <= n)
                    triangles.push_back({vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
            }
        }
    }
    return smoothness(points, triangles, [](Vec3) { return true; });
}

// How much larger the angles between neighbouring facets are than on the same ellipsoid meshed directly at
// the same mean edge length, when one of its slices is at `shift`.
double roughness(const Ellipsoid& solid, double shift) {
    Drawing drawing;
    double low = 1e9, high = -1e9;
    const int most = static_cast<int>(std::ceil(solid.axes.x / solid.gap));
    for (int k = -most; k <= most; ++k) {
        const double z = k * solid.gap + shift;
        const Polygon polygon = section(solid, z);
        if (polygon.empty()) continue;
        drawing.add(0, z, polygon);
        low = std::min(low, z);
        high = std::max(high, z);
    }
    const Model model = certified_model(drawing);
    EXPECT_FALSE(model.mesh.cells.empty());
    // Between the first and the last slice: what lies beyond is the caps' business.
    const Smoothness sliced = smoothness(model.mesh.points, structure_surface(model.mesh, model.regions, 0),
                                         [&](Vec3 p) { return p.z > low + 0.01 && p.z < high - 0.01; });
    Smoothness reference = direct(solid, 12);
    const int n = static_cast<int>(std::round(12 * reference.edge / sliced.edge));
    reference = direct(solid, n);
    return sliced.angle / (reference.angle * sliced.edge / reference.edge);
}

double mean_roughness(const Ellipsoid& solid, int positions) {
    double total = 0;
    for (int n = 0; n < positions; ++n) {
        const double ratio = roughness(solid, (n + 0.3) / positions * solid.gap);
        EXPECT_LT(ratio, 1.3) << n;
        total += ratio;
    }
    return total / positions;
}

// One position of the slices says little: from one to the next the ratio changes by a twentieth.
TEST(Terraces, a_leaning_ellipsoid_of_slices_is_about_as_smooth_as_one_meshed_directly) {
    EXPECT_LE(mean_roughness({}, 6), 1.2);
}

// Flat caps, where an outline shrinks by many gaps from slice to slice; upright, leaning, lying; finer and
// coarser. The mesh that they are compared with is better than any mesher's: an ellipsoid's icosahedron is
// convex, and so are all its edges; CGAL's angles are 1.09 to 1.21 times as large on these solids.
TEST(Terraces, ellipsoids_at_any_angle_and_spacing_have_none) {
    const std::vector<Ellipsoid> solids{
        {{32, 24, 18}, {1, 0.3, 0.26}, 3, 2.5}, {{32, 24, 18}, {1, 0.2, 0.1}, 2, 2},
        {{50, 35, 25}, {1, 0.5, 0.35}, 3, 2},   {{30, 30, 15}, {1, 0, 0.58}, 3, 2.5},
        {{40, 20, 20}, {1, 0.1, 1}, 3, 2.5},    {{32, 24, 18}, {1, 0.3, 1.7}, 2, 2.5},
        {{50, 35, 25}, {1, 0.4, 0.4}, 5, 4},    {{45, 30, 22}, {1, 0.4, 0.2}, 3, 2}};
    double total = 0;
    for (const Ellipsoid& solid : solids) {
        const double ratio = mean_roughness(solid, 2);
        EXPECT_LE(ratio, 1.27) << solid.axes.x << " " << solid.along.z << " " << solid.gap;
        total += ratio;
    }
    EXPECT_LE(total / static_cast<double>(solids.size()), 1.2);
}

}  // namespace
}  // namespace anatomesh::terraces_test
