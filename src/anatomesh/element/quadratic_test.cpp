#include "anatomesh/element/quadratic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::quadratic_test {
namespace {

using fixtures::AnalyticField;

constexpr double radius = 10;
const Vec3 centre{100, -50, 30};
const RegionTable one_region{{{}, {0}}};
const RegionTable two_regions{{{}, {0}, {1}}};

// Concentric cubes of a grid pulled onto concentric spheres around `centre`: a ball of 6 n^3 cells.
TetMesh ball_mesh(int n, const std::function<Region(int, int, int)>& region) {
    return testing::brick_mesh({n, n, n}, region, [n](int i, int j, int k) {
        const Vec3 p{2.0 * i / n - 1, 2.0 * j / n - 1, 2.0 * k / n - 1};
        const double cube = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        return cube == 0 ? centre : centre + (radius * cube / length(p)) * p;
    });
}
Region all(int, int, int) {
    return 1;
}

QuadraticResult bent(const TetMesh& mesh, const RegionTable& regions, const StructureField& field,
                     int threads = 1, const QuadraticOptions& options = {},
                     std::vector<std::array<std::uint32_t, 2>> segments = {}) {
    RunContext context;
    context.threads = threads;
    auto result = quadratic_elements(mesh, regions, {field, centre}, segments, options, context);
    EXPECT_TRUE(result.ok());
    return std::move(result).value();
}

QuadraticElement random_element(std::mt19937& random, double wobble) {
    std::uniform_real_distribution<double> unit(-1, 1);
    QuadraticElement element;
    element.corners = {Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (Vec3& p : element.corners) p += 0.2 * Vec3{unit(random), unit(random), unit(random)};
    for (std::size_t e = 0; e < 6; ++e) {
        const auto [a, b] = cell_edges[e];
        element.mid_nodes[e] = 0.5 * (element.corners[static_cast<std::size_t>(a)] +
                                      element.corners[static_cast<std::size_t>(b)]) +
                               wobble * Vec3{unit(random), unit(random), unit(random)};
    }
    return element;
}

// The element's own map, by its shape functions.
Vec3 position(const QuadraticElement& element, const std::array<double, 4>& l) {
    Vec3 p;
    for (std::size_t i = 0; i < 4; ++i) p += (l[i] * (2 * l[i] - 1)) * element.corners[i];
    for (std::size_t e = 0; e < 6; ++e) {
        const auto a = static_cast<std::size_t>(cell_edges[e][0]),
                   b = static_cast<std::size_t>(cell_edges[e][1]);
        p += (4 * l[a] * l[b]) * element.mid_nodes[e];
    }
    return p;
}

std::array<double, 4> random_place(std::mt19937& random) {
    std::exponential_distribution<double> share;
    std::array<double, 4> l{share(random), share(random), share(random), share(random)};
    const double sum = l[0] + l[1] + l[2] + l[3];
    for (double& each : l) each /= sum;
    return l;
}

TEST(Jacobian, is_that_of_the_shape_functions) {
    std::mt19937 random(1);
    for (int n = 0; n < 200; ++n) {
        const QuadraticElement element = random_element(random, 0.2);
        const auto l = random_place(random);
        std::array<Vec3, 3> derivative;
        constexpr double h = 1e-5;
        for (std::size_t k = 0; k < 3; ++k) {
            auto forth = l, back = l;
            forth[k + 1] += h, forth[0] -= h;
            back[k + 1] -= h, back[0] += h;
            derivative[k] = (1 / (2 * h)) * (position(element, forth) - position(element, back));
        }
        EXPECT_NEAR(jacobian_at(element, l), dot(cross(derivative[0], derivative[1]), derivative[2]), 1e-8);
    }
}

TEST(Jacobian, lies_between_its_coefficients_and_meets_them_at_the_corners) {
    std::mt19937 random(2);
    for (int n = 0; n < 200; ++n) {
        const QuadraticElement element = random_element(random, 0.3);
        const auto coefficients = jacobian_coefficients(element);
        const auto [low, high] = std::minmax_element(coefficients.begin(), coefficients.end());
        for (int k = 0; k < 50; ++k) {
            const double value = jacobian_at(element, random_place(random));
            EXPECT_GE(value, *low - 1e-12);
            EXPECT_LE(value, *high + 1e-12);
        }
        for (std::size_t corner = 0; corner < 4; ++corner) {
            std::array<double, 4> l{};
            l[corner] = 1;
            constexpr std::array<std::size_t, 4> place{0, 10, 16, 19};
            EXPECT_NEAR(coefficients[place[corner]], jacobian_at(element, l), 1e-12);
        }
    }
}

TEST(Jacobian, of_a_straight_element_is_constant) {
    std::mt19937 random(3);
    for (int n = 0; n < 50; ++n) {
        const QuadraticElement element = random_element(random, 0);
        const auto& c = element.corners;
        const double volume = signed_volume(c[0], c[1], c[2], c[3]);
        for (const double each : jacobian_coefficients(element)) EXPECT_NEAR(each, 6 * volume, 1e-12);
        EXPECT_NEAR(least_jacobian(element), 1, 1e-12);
        EXPECT_NEAR(quadratic_volume(element), volume, 1e-13);
    }
}

TEST(Quadratic, straight_nodes_lie_in_the_middles_and_are_shared) {
    const TetMesh mesh = ball_mesh(3, all);
    const MidNodes mid_nodes = straight_mid_nodes(mesh);
    ASSERT_EQ(mid_nodes.cells.size(), mesh.cells.size());
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        for (std::size_t e = 0; e < 6; ++e) {
            const Vec3 a = mesh.points[mesh.cells[c][static_cast<std::size_t>(cell_edges[e][0])]];
            const Vec3 b = mesh.points[mesh.cells[c][static_cast<std::size_t>(cell_edges[e][1])]];
            EXPECT_EQ(mid_nodes.points[mid_nodes.cells[c][e]], 0.5 * (a + b));
        }
    }
    // Euler: vertices - edges + facets - cells = 1 for a ball; facets = (4 cells + boundary) / 2.
    const auto facets = (4 * mesh.cells.size() + 6 * 2 * 9) / 2;
    EXPECT_EQ(mesh.points.size() - mid_nodes.points.size() + facets - mesh.cells.size(), 1u);
}

TEST(Quadratic, nodes_of_the_surface_lie_on_it) {
    const TetMesh mesh = ball_mesh(6, all);
    const AnalyticField field({fixtures::ball({}, radius)}, 12);
    const QuadraticResult result = bent(mesh, one_region, field);
    const QuadraticStats& stats = result.stats;
    EXPECT_EQ(stats.interface_nodes, 3u * 6 * 2 * 36 / 2);
    EXPECT_EQ(stats.junction_nodes + stats.segment_nodes + stats.out_of_reach, 0u);
    EXPECT_EQ(stats.on_interface + stats.pulled_back + stats.straightened, stats.interface_nodes);
    std::size_t on = 0;
    for (const Vec3& p : result.mid_nodes.points) on += std::abs(length(p - centre) - radius) < 1e-5;
    EXPECT_EQ(on, stats.on_interface);
    EXPECT_GT(stats.on_interface, stats.interface_nodes / 2);
}

TEST(Quadratic, volume_of_a_ball_converges_fast) {
    const AnalyticField field({fixtures::ball({}, radius)}, 12);
    const double exact = 4 * std::numbers::pi / 3 * radius * radius * radius;
    QuadraticOptions options;
    options.min_jacobian = 1e-6;
    double before = 0;
    for (const int n : {4, 8, 16}) {
        const QuadraticResult result = bent(ball_mesh(n, all), one_region, field, 1, options);
        const double error = std::abs(result.stats.volume_mm3 / exact - 1);
        if (before > 0) {
            EXPECT_LT(error, before / 6);  // the few flat cells in the corners do not bend
        }
        before = error;
    }
    EXPECT_GT(before, 0);
    EXPECT_LT(before, 1e-4);
}

TEST(Quadratic, jacobians_keep_the_bound_whatever_it_is) {
    const TetMesh mesh = ball_mesh(4, all);
    // A ball a little larger: every node of the surface has a way to go.
    const AnalyticField field({fixtures::ball({}, 1.06 * radius)}, 14);
    std::uint64_t pulled_back = 0;
    for (const double bound : {0.1, 0.3, 0.6, 0.85}) {
        QuadraticOptions options;
        options.min_jacobian = bound;
        const QuadraticResult result = bent(mesh, one_region, field, 1, options);
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            EXPECT_GE(least_jacobian(element_of(mesh, result.mid_nodes, c)), bound);
        }
        EXPECT_GE(result.stats.least_jacobian, bound);
        EXPECT_GE(result.stats.pulled_back + result.stats.straightened, pulled_back);
        pulled_back = result.stats.pulled_back + result.stats.straightened;
    }
    EXPECT_GT(pulled_back, 0u);
}

TEST(Quadratic, interfaces_inside_bend_too_and_inner_edges_do_not) {
    constexpr int n = 8;
    const auto core = [](int i, int j, int k) -> Region {
        const auto inside = [](int x) { return x >= n / 4 && x < n - n / 4; };
        return inside(i) && inside(j) && inside(k) ? 2 : 1;
    };
    const TetMesh mesh = ball_mesh(n, core);
    const AnalyticField field({fixtures::shell({}, radius, radius / 2), fixtures::ball({}, radius / 2)}, 12);
    const QuadraticResult result = bent(mesh, two_regions, field);
    std::size_t inner = 0, outer = 0, other = 0;
    const MidNodes straight = straight_mid_nodes(mesh);
    for (std::size_t i = 0; i < straight.points.size(); ++i) {
        if (result.mid_nodes.points[i] == straight.points[i]) continue;
        const double r = length(result.mid_nodes.points[i] - centre);
        inner += std::abs(r - radius / 2) < 1e-5;
        outer += std::abs(r - radius) < 1e-5;
        ++other;
    }
    EXPECT_GT(inner, 100u);
    EXPECT_GT(outer, 400u);
    EXPECT_EQ(inner + outer, result.stats.on_interface);
    EXPECT_EQ(other, result.stats.on_interface + result.stats.pulled_back);
}

TEST(Quadratic, nodes_of_segments_and_junctions_stay_in_the_middle) {
    const auto halves = [](int, int, int k) -> Region { return k < 2 ? 1 : 2; };
    const TetMesh mesh = ball_mesh(4, halves);
    const AnalyticField field({[](Vec3 p) { return std::max(length(p) - radius, p.z); },
                               [](Vec3 p) { return std::max(length(p) - radius, -p.z); }},
                              12);
    // Segments: the edges that leave vertex 0.
    std::vector<std::array<std::uint32_t, 2>> segments;
    for (const Cell& cell : mesh.cells) {
        for (const std::uint32_t v : cell) {
            if (std::find(cell.begin(), cell.end(), 0u) != cell.end() && v != 0) segments.push_back({0, v});
        }
    }
    const QuadraticResult result = bent(mesh, two_regions, field, 1, {}, segments);
    const MidNodes straight = straight_mid_nodes(mesh);
    EXPECT_EQ(result.stats.junction_nodes, 16u);  // the circle where both halves meet the outside
    EXPECT_GT(result.stats.segment_nodes, 2u);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        for (std::size_t e = 0; e < 6; ++e) {
            const std::uint32_t a = mesh.cells[c][static_cast<std::size_t>(cell_edges[e][0])];
            const std::uint32_t b = mesh.cells[c][static_cast<std::size_t>(cell_edges[e][1])];
            const std::uint32_t n = result.mid_nodes.cells[c][e];
            const bool flat = mesh.points[a].z == centre.z && mesh.points[b].z == centre.z;
            if (a == 0 || b == 0 || flat) {
                EXPECT_EQ(result.mid_nodes.points[n], straight.points[n]);
            }
        }
    }
}

TEST(Quadratic, same_bytes_for_any_number_of_threads) {
    const TetMesh mesh = ball_mesh(10, all);
    const AnalyticField field({fixtures::ball({}, 1.03 * radius)}, 12);
    EXPECT_EQ(bent(mesh, one_region, field, 1).mid_nodes, bent(mesh, one_region, field, 2).mid_nodes);
}

TEST(Quadratic, stops_when_cancelled) {
    const AnalyticField field({fixtures::ball({}, radius)}, 12);
    RunContext context;
    const std::atomic<bool> cancel = true;
    context.cancel = &cancel;
    const TetMesh mesh = ball_mesh(2, all);
    const auto result = quadratic_elements(mesh, one_region, {field, centre}, {}, {}, context);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, "E-RUN-001");
}

}  // namespace
}  // namespace anatomesh::quadratic_test
