#include "anatomesh/element/grey.h"

#include <gtest/gtest.h>

#include <cmath>

#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::grey_test {
namespace {

// An image around the origin with oblique, unequal steps, one of them mirrored; its voxels by position.
GreyImage image(double (*value)(Vec3), std::uint32_t voxels = 40) {
    GreyImage image;
    image.geometry.size = {voxels, voxels + 3, voxels - 5};
    image.geometry.step = {Vec3{0.8, 0.05, 0}, Vec3{-0.1, -0.9, 0.02}, Vec3{0, 0.3, 1.1}};
    const auto& g = image.geometry;
    const Vec3 middle = g.position(0.5 * (g.size[0] - 1), 0.5 * (g.size[1] - 1), 0.5 * (g.size[2] - 1));
    image.geometry.origin = image.geometry.origin - middle;
    image.source = "image";
    for (std::uint32_t k = 0; k < g.size[2]; ++k) {
        for (std::uint32_t j = 0; j < g.size[1]; ++j) {
            for (std::uint32_t i = 0; i < g.size[0]; ++i) {
                image.voxels.push_back(static_cast<float>(value(image.geometry.position(i, j, k))));
            }
        }
    }
    return image;
}

double linear(Vec3 p) {
    return 100 + 3 * p.x - 7 * p.y + 11 * p.z;
}
double square(Vec3 p) {
    return dot(p, p);
}

TetMesh ball(int n, double radius) {
    return testing::rounded_mesh(n, radius, [](int, int, int) -> Region { return 1; });
}

GreyResult values(const TetMesh& mesh, const GreyImage& image, int threads = 1,
                  const GreyOptions& options = {}) {
    RunContext context;
    context.threads = threads;
    auto result = grey_values(mesh, image, options, context);
    EXPECT_TRUE(result.ok());
    return std::move(result).value();
}

Vec3 centroid(const TetMesh& mesh, std::size_t c) {
    Vec3 sum;
    for (const std::uint32_t v : mesh.cells[c]) sum += mesh.points[v];
    return 0.25 * sum;
}

TEST(Grey, is_exact_where_the_image_is_linear) {
    const TetMesh mesh = ball(4, 10);
    const GreyResult result = values(mesh, image(&linear));
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        EXPECT_NEAR(result.values[c], linear(centroid(mesh, c)), 1e-3);
    }
    EXPECT_EQ(result.stats.cells_outside + result.stats.cells_cut, 0u);
    EXPECT_LT(result.stats.low, result.stats.mean);
    EXPECT_LT(result.stats.mean, result.stats.high);
}

TEST(Grey, is_the_mean_over_the_cell_not_the_value_at_its_centre) {
    const TetMesh mesh = ball(2, 12);
    const GreyResult result = values(mesh, image(&square));
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        // Mean of |p|^2 over a tetrahedron: (sum of |v|^2 + 16 |centroid|^2) / 20.
        double exact = 16 * square(centroid(mesh, c));
        for (const std::uint32_t v : mesh.cells[c]) exact += square(mesh.points[v]);
        exact /= 20;
        const double at_centre = square(centroid(mesh, c));
        EXPECT_NEAR(result.values[c], exact, 0.1 * (exact - at_centre) + 0.6);
        EXPECT_GT(result.values[c], at_centre);
    }
}

TEST(Grey, cells_beyond_the_image_take_the_nearest_voxels) {
    TetMesh mesh = ball(4, 10);
    for (Vec3& p : mesh.points) p.x += 14;
    const GreyResult result = values(mesh, image(&linear));
    EXPECT_GT(result.stats.cells_outside, 10u);
    EXPECT_GT(result.stats.cells_cut, 10u);
    for (const double value : result.values) EXPECT_LT(std::abs(value - 100), 500);
    for (Vec3& p : mesh.points) p.x += 1000;
    RunContext context;
    const auto refused = grey_values(mesh, image(&linear), {}, context);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "E-ELM-001");
    EXPECT_EQ(refused.error().place.file, "image");
}

TEST(Grey, an_image_of_one_slice_is_an_image) {
    GreyImage one;
    one.geometry.size = {2, 1, 1};
    one.geometry.step = {Vec3{20, 0, 0}, Vec3{0, 20, 0}, Vec3{0, 0, 20}};
    one.geometry.origin = {-10, 0, 0};
    one.voxels = {0, 20};
    const TetMesh mesh = ball(3, 9);
    const GreyResult result = values(mesh, one);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        EXPECT_NEAR(result.values[c], 10 + centroid(mesh, c).x, 1e-9);
    }
}

TEST(Grey, same_values_for_any_number_of_threads) {
    const TetMesh mesh = ball(12, 12);
    const GreyImage grey = image(&square);
    EXPECT_EQ(values(mesh, grey, 1).values, values(mesh, grey, 2).values);
}

}  // namespace
}  // namespace anatomesh::grey_test
