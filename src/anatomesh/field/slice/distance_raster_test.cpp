#include "anatomesh/field/slice/distance_raster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/slice/bit_volume.h"

namespace anatomesh::distance_raster_test {
namespace {

using namespace fixtures;

double brute_force(const std::vector<Edge2>& edges, Vec2 q) {
    double nearest = 1e300;
    for (const Edge2& e : edges) {
        const Vec2 along = e.b - e.a;
        const double t = std::clamp(dot(q - e.a, along) / squared_length(along), 0.0, 1.0);
        nearest = std::min(nearest, length(q - e.a - t * along));
    }
    return nearest;
}

// Every value against brute force to 1e-9 of the pixel; its sign against the bit volume.
void expect_exact(const std::vector<Edge2>& edges, const PixelGrid& grid) {
    const std::vector<double> distance = distance_raster(edges, grid);
    ASSERT_EQ(distance.size(), std::size_t{grid.nx} * grid.ny);
    BitVolume bits(grid, 1);
    bits.fill(0, edges);
    const double tolerance = 1e-9 * std::min(grid.step.x, grid.step.y);
    for (std::uint32_t j = 0; j < grid.ny; ++j) {
        for (std::uint32_t i = 0; i < grid.nx; ++i) {
            const Vec2 q = grid.low + Vec2{i * grid.step.x, j * grid.step.y};
            const double value = distance[std::size_t{j} * grid.nx + i];
            const double wanted = (bits.inside(i, j, 0) ? -1 : 1) * brute_force(edges, q);
            ASSERT_NEAR(value, wanted, tolerance) << i << " " << j;
            ASSERT_EQ(std::signbit(value), bits.inside(i, j, 0) && value != 0) << i << " " << j;
        }
    }
}

TEST(DistanceRaster, equals_brute_force_on_random_polygons_with_holes) {
    std::mt19937 random(31);
    for (int trial = 0; trial < 12; ++trial) {
        const Vec2 at{300.0 * trial, -150.25 * trial};
        const std::vector<Edge2> edges =
            edges_of({star(at, 8, 20, 7 + 30 * trial, random), reversed(star(at, 3, 7.9, 9, random)),
                      star(at, 0.5, 2.9, 30, random), star(at + Vec2{41, 2}, 1, 15, 50, random)});
        expect_exact(edges, {at - Vec2{31, 27.5}, {0.83, 0.61}, 121, 93});
        expect_exact(edges, {at - Vec2{5, 3}, {0.25, 0.25}, 40, 33});  // a part of the region
    }
}

// Edges along the rows and columns, vertices and edges on grid points, right angles and straight vertices.
TEST(DistanceRaster, equals_brute_force_where_everything_lies_on_the_grid) {
    const Ring square{{2, 2}, {6, 2}, {10, 2}, {10, 10}, {6, 10}, {2, 10}, {2, 6}};
    const Ring diamond{{0, -6}, {6, 0}, {0, 6}, {-6, 0}};
    const Ring hole{{4, 4}, {4, 8}, {8, 8}, {8, 4}};
    expect_exact(edges_of({square, hole}), {{-3, -3}, {1, 1}, 20, 21});
    expect_exact(edges_of({diamond}), {{-9, -9}, {0.5, 0.5}, 40, 40});
    // Contours that touch at a vertex, and one that turns back on itself.
    expect_exact(edges_of({{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, {{4, 4}, {8, 4}, {8, 8}, {4, 8}}}),
                 {{-4, -4}, {1, 1}, 17, 17});
    expect_exact(edges_of({{{0, 0}, {5, 0}, {9, 0}, {5, 0}, {5, 5}, {0, 5}}}), {{-4, -4}, {1, 1}, 19, 17});
}

TEST(DistanceRaster, equals_brute_force_for_edges_nearly_along_the_rows) {
    for (const double tilt : {1e-17, 1e-15, 1e-12, 1e-8, 1e-4}) {
        const Ring box{{0, 0}, {100, 100 * tilt}, {100 - 50 * tilt, 50}, {-50 * tilt, 50}};
        expect_exact(edges_of({box}), {{-20, -20}, {1, 1}, 141, 91});
    }
}

// Spikes, blunt corners, edges far longer and far shorter than a pixel, on grids beside, across and within
// them, with pixels of any shape.
TEST(DistanceRaster, equals_brute_force_for_wedges_of_any_angle) {
    std::mt19937 random(77);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int trial = 0; trial < 300; ++trial) {
        const double size = std::pow(10.0, 2 + 2 * unit(random)), thin = std::pow(10.0, 3 * unit(random) - 3);
        Ring ring;
        for (int i = 0; i < 3 + trial % 3; ++i)
            ring.push_back({size * unit(random), (trial % 2 ? thin : 1) * size * unit(random)});
        if (trial % 4 == 0) ring.push_back(ring.back() + Vec2{1e-7 * unit(random), 1e-7 * unit(random)});
        const Vec2 step{std::pow(4.0, unit(random)), std::pow(4.0, unit(random))};
        expect_exact(edges_of({ring}), {{30 * unit(random), 30 * unit(random)}, step, 37, 23});
        if (HasFatalFailure()) FAIL() << "trial " << trial;
    }
}

TEST(DistanceRaster, zero_on_grid_points_that_are_vertices) {
    const std::vector<double> distance =
        distance_raster(edges_of({{{0, 0}, {4, 1}, {3, 5}, {-1, 3}}}), {{-2, -2}, {1, 1}, 8, 9});
    for (const auto& [i, j] : {std::pair{2, 2}, {6, 3}, {5, 7}, {1, 5}})
        EXPECT_EQ(distance[static_cast<std::size_t>(8 * j + i)], 0.0);
}

TEST(DistanceRaster, grows_by_one_millimetre_a_millimetre_everywhere) {
    std::mt19937 random(5);
    const PixelGrid grid{{-64, -64}, {1, 1}, 128, 128};
    const std::vector<double> distance =
        distance_raster(edges_of({star({0.3, 0.2}, 20, 50, 80, random)}), grid);
    for (std::size_t n = 0; n + 1 < distance.size(); ++n) {
        if (n % 128 == 127) continue;
        ASSERT_LE(std::abs(distance[n + 1] - distance[n]), 1 + 1e-9);
    }
}

}  // namespace
}  // namespace anatomesh::distance_raster_test
