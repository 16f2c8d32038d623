#include "anatomesh/measure/hausdorff.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "anatomesh/geom/point_triangle.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::hausdorff_test {
namespace {

Region everywhere(int, int, int) {
    return 1;
}

SurfaceMesh surface_of(const TetMesh& mesh) {
    return extract_interfaces(mesh);
}

// The surface pushed out onto the sphere of the given radius.
SurfaceMesh sphere(int n, double radius) {
    SurfaceMesh surface = surface_of(testing::rounded_mesh(n, radius, everywhere));
    for (Vec3& p : surface.points) p = radius * normalized(p);
    return surface;
}

SurfaceMesh moved(SurfaceMesh surface, Vec3 by) {
    for (Vec3& p : surface.points) p = p + by;
    return surface;
}

SurfaceDistance distance(const SurfaceMesh& a, const SurfaceMesh& b, int threads = 1) {
    RunContext context;
    context.threads = threads;
    auto result = surface_distance(a, b, {20000}, context);
    EXPECT_TRUE(result.ok());
    return result.value();
}

TEST(Hausdorff, a_surface_is_nowhere_from_itself) {
    const SurfaceMesh surface = sphere(10, 50);
    const SurfaceDistance d = distance(surface, surface);
    EXPECT_LT(d.both.max, 1e-12);
}

TEST(Hausdorff, concentric_spheres_are_their_difference_apart) {
    const SurfaceMesh inner = sphere(24, 50), outer = sphere(30, 53);
    const SurfaceDistance d = distance(inner, outer);
    // The polyhedra lie within their sagittas of the spheres: the longest edges span 7 degrees.
    const double sagitta = 53 * (1 - std::cos(0.1));
    for (const DistanceStats& stats : {d.a_to_b, d.b_to_a, d.both}) {
        EXPECT_NEAR(stats.min, 3.0, sagitta);
        EXPECT_NEAR(stats.mean, 3.0, 0.1);
        EXPECT_NEAR(stats.rms, 3.0, 0.1);
        EXPECT_NEAR(stats.max, 3.0, sagitta);
        EXPECT_LE(stats.mean, stats.rms);
        EXPECT_LE(stats.p95, stats.max);
        EXPECT_LE(stats.min, stats.mean);
    }
}

TEST(Hausdorff, a_moved_slab_is_the_move_apart_and_one_way_sees_less) {
    const SurfaceMesh slab = surface_of(testing::brick_mesh({20, 20, 2}, everywhere));
    const SurfaceDistance d = distance(slab, moved(slab, {0, 0, 0.5}));
    EXPECT_NEAR(d.both.max, 0.5, 1e-12);
    EXPECT_NEAR(d.a_to_b.p95, 0.5, 1e-12);

    // A part of the surface is on the whole; the whole is not on the part.
    SurfaceMesh part = slab;
    part.triangles.resize(part.triangles.size() / 2);
    part.sides.clear();
    const SurfaceDistance one = distance(part, slab);
    EXPECT_LT(one.a_to_b.max, 1e-12);
    EXPECT_GT(one.b_to_a.max, 1.0);
    EXPECT_EQ(one.both.max, one.b_to_a.max);
}

TEST(Hausdorff, the_tree_finds_what_a_search_of_all_triangles_finds) {
    const SurfaceMesh surface = sphere(9, 20);
    const ClosestPoint closest(surface);
    std::mt19937 random(1);
    for (int trial = 0; trial < 300; ++trial) {
        const auto coordinate = [&] { return static_cast<double>(random() % 80) - 40; };
        const Vec3 p{coordinate(), coordinate(), coordinate()};
        double least = std::numeric_limits<double>::infinity();
        for (const Triangle& f : surface.triangles) {
            least = std::min(least, point_triangle_distance(p, surface.points[f[0]], surface.points[f[1]],
                                                            surface.points[f[2]]));
        }
        EXPECT_EQ(closest.distance(p), least);
    }
}

TEST(Hausdorff, samples_are_spread_by_area) {
    SurfaceMesh two;
    two.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {10, 0, 0}, {13, 0, 0}, {10, 1, 0}};
    two.triangles = {{0, 1, 2}, {3, 4, 5}};
    const std::vector<Vec3> samples = area_samples(two, 4000);
    std::size_t first = 0;
    Vec3 sum;
    for (const Vec3& p : samples) {
        if (p.x > 5) continue;
        ++first;
        sum += p;
        EXPECT_GE(p.x, 0);
        EXPECT_LE(p.x + p.y, 1 + 1e-12);
    }
    EXPECT_EQ(first, 1000u);
    EXPECT_NEAR(sum.x / 1000, 1.0 / 3, 0.005);
    EXPECT_NEAR(sum.y / 1000, 1.0 / 3, 0.005);
}

TEST(Hausdorff, same_figures_for_any_number_of_threads) {
    const SurfaceMesh a = sphere(12, 50), b = sphere(15, 52);
    const SurfaceDistance one = distance(a, b, 1), three = distance(a, b, 3);
    EXPECT_EQ(one.both.mean, three.both.mean);
    EXPECT_EQ(one.a_to_b.rms, three.a_to_b.rms);
    EXPECT_EQ(one.b_to_a.p95, three.b_to_a.p95);
}

TEST(Hausdorff, bad_surfaces_are_refused_with_a_code) {
    const SurfaceMesh good = sphere(4, 10);
    SurfaceMesh not_finite = good, flat;
    not_finite.points[0].x = std::numeric_limits<double>::quiet_NaN();
    flat.points = {{1, 2, 3}, {2, 3, 4}, {3, 4, 5}};
    flat.triangles = {{0, 1, 2}};
    RunContext context;
    EXPECT_EQ(surface_distance(good, {}, {}, context).error().code, "E-MEA-001");
    EXPECT_EQ(surface_distance(not_finite, good, {}, context).error().code, "E-MEA-002");
    EXPECT_EQ(surface_distance(good, flat, {}, context).error().code, "E-MEA-003");
    EXPECT_EQ(surface_distance(good, good, {0}, context).error().code, "E-MEA-004");
}

}  // namespace
}  // namespace anatomesh::hausdorff_test
