// Terraces: a model of slices must be about as smooth as a mesh made on the solid itself.
#include <gtest/gtest.h>

#include <array>
#include <map>

#include "anatomesh/mesh/topology.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh {
namespace {

using namespace fixtures;

// x = turned (axes * unit ball): an ellipsoid that leans against all axes.
constexpr Vec3 axes{32, 24, 18};

struct Turn {
    Vec3 x, y, z;
    Vec3 operator()(Vec3 p) const { return p.x * x + p.y * y + p.z * z; }
    Vec3 back(Vec3 p) const { return {dot(p, x), dot(p, y), dot(p, z)}; }
};

Turn turn() {
    const Vec3 x = normalized({1, 0.4, 0.6}), y = normalized(cross({0, 0, 1}, x));
    return {x, y, cross(x, y)};
}

// The ellipse in which the plane at z cuts the ellipsoid, its points about `spacing` apart; empty where it
// does not.
Polygon section(double z, double spacing) {
    const Turn turned = turn();
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
        std::max(8, static_cast<int>(2 * pi * std::sqrt(rest / std::sqrt(determinant)) / spacing));
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
Smoothness direct(int n) {
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
    const Turn turned = turn();
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
// the same mean edge length, when its slices are at -40.5 + shift, 3 mm apart.
double roughness(double shift) {
    Drawing drawing;
    double low = 1e9, high = -1e9;
    for (double z = -40.5 + shift; z < 41; z += 3) {
        const Polygon polygon = section(z, 2.5);
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
    Smoothness reference = direct(12);
    const int n = static_cast<int>(std::round(12 * reference.edge / sliced.edge));
    reference = direct(n);
    return sliced.angle / (reference.angle * sliced.edge / reference.edge);
}

// One position of the slices says little: from one to the next the ratio changes by a twentieth.
TEST(Terraces, a_leaning_ellipsoid_of_slices_is_about_as_smooth_as_one_meshed_directly) {
    constexpr int positions = 6;
    double total = 0;
    for (int n = 0; n < positions; ++n) {
        const double ratio = roughness(0.5 * n);
        EXPECT_LT(ratio, 1.3) << n;
        total += ratio;
    }
    EXPECT_LE(total / positions, 1.2);
}

}  // namespace
}  // namespace anatomesh
