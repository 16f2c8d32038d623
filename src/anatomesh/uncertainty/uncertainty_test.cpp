#include <gtest/gtest.h>

#include <cmath>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/uncertainty/left_out.h"
#include "anatomesh/uncertainty/surface_uncertainty.h"
#include "anatomesh/uncertainty/where_next.h"

namespace anatomesh {
namespace {

using namespace fixtures;

// A cylinder that widens from slice `from` on, cut every 2 mm but where `gap` says.
ContourSet cylinder(int slices, double widening = 0, int missing = -1) {
    SetBuilder builder;
    for (int k = 0; k < slices; ++k) {
        if (k == missing) continue;
        builder.slice(axial(2.0 * k));
        builder.ring(0, circle({}, 10 + widening * k * k, 60));
    }
    return builder.set;
}

LeftOut left_out(const ContourSet& set, int threads = 1) {
    RunContext context;
    context.threads = threads;
    return leave_slices_out(set, {}, context).value();
}

// A tube of triangles, two to a square, as the surface of a mesh: tetrahedra from the axis to the squares.
struct Tube {
    TetMesh mesh;
    RegionTable regions;
};

Tube tube(double height, int around = 48, int steps = 48) {
    Tube made;
    made.regions.members.push_back({0});
    auto& points = made.mesh.points;
    for (int k = 0; k <= steps; ++k) {
        points.push_back({0, 0, height * k / steps});
        for (int i = 0; i < around; ++i) {
            const double a = 2 * std::numbers::pi * i / around;
            points.push_back({10 * std::cos(a), 10 * std::sin(a), height * k / steps});
        }
    }
    const auto index = [&](int k, int i) {
        return static_cast<std::uint32_t>(k * (around + 1) + 1 + i % around);
    };
    for (int k = 0; k < steps; ++k) {
        const auto low = static_cast<std::uint32_t>(k * (around + 1)),
                   high = low + static_cast<std::uint32_t>(around) + 1;
        for (int i = 0; i < around; ++i) {
            const std::uint32_t a = index(k, i), b = index(k, i + 1), c = index(k + 1, i),
                                d = index(k + 1, i + 1);
            for (const Cell& cell : {Cell{low, a, b, high}, Cell{a, b, high, d}, Cell{a, high, c, d}}) {
                const Vec3 p = points[cell[0]];
                const double six = dot(cross(points[cell[1]] - p, points[cell[2]] - p), points[cell[3]] - p);
                made.mesh.cells.push_back(six > 0 ? cell : Cell{cell[1], cell[0], cell[2], cell[3]});
                made.mesh.regions.push_back(1);
            }
        }
    }
    return made;
}

TEST(LeftOut, a_cylinder_is_foretold_exactly_between_its_ends) {
    const ContourSet set = cylinder(10);
    const LeftOut errors = left_out(set);
    ASSERT_EQ(errors.slices.size(), 10u);
    for (std::size_t k = 1; k < 9; ++k) EXPECT_LT(errors.slices[k].max_mm, 1e-6) << k;
    // At the ends the others stop half-way.
    EXPECT_NEAR(errors.slices.front().mean_mm, 1, 0.3);
    EXPECT_NEAR(errors.slices.back().mean_mm, 1, 0.3);
    for (std::size_t n = 0; n < set.points.size(); ++n)
        EXPECT_EQ(errors.points[n].is_end, n < 60 || n >= set.points.size() - 60);
    for (std::size_t n = 60; n < 120; ++n) EXPECT_NEAR(errors.points[n].gap_mm, 2, 1e-6);
}

TEST(LeftOut, the_error_of_a_lone_bump_is_its_height) {
    SetBuilder builder;
    for (int k = 0; k < 9; ++k) {
        builder.slice(axial(2.0 * k));
        builder.ring(0, circle({}, k == 4 ? 11.5 : 10, 60));
    }
    const LeftOut errors = left_out(builder.set);
    EXPECT_NEAR(errors.slices[4].mean_mm, 1.5, 0.1);
    EXPECT_LT(errors.slices[1].mean_mm, 0.2);
}

TEST(LeftOut, is_the_same_for_any_number_of_threads) {
    const ContourSet set = cylinder(8, 0.05);
    const LeftOut one = left_out(set), three = left_out(set, 3);
    for (std::size_t n = 0; n < set.points.size(); ++n) {
        EXPECT_EQ(one.points[n].error_mm, three.points[n].error_mm);
        EXPECT_EQ(one.points[n].gap_mm, three.points[n].gap_mm);
    }
}

TEST(LeftOut, one_slice_alone_is_refused) {
    RunContext context;
    const auto result = leave_slices_out(cylinder(1), {}, context);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, "E-UNC-001");
}

TEST(SurfaceUncertainty, is_zero_on_contours_and_grows_with_the_distance_from_them) {
    const ContourSet set = cylinder(10, 0.05);
    const Tube solid = tube(18);
    RunContext context;
    const SurfaceUncertainty found =
        surface_uncertainty(set, left_out(set), solid.mesh, solid.regions, context);
    for (std::size_t v = 0; v < solid.mesh.points.size(); ++v) {
        EXPECT_LE(found.expected[v], found.left_out[v] * (1 + 1e-6));
        if (length(Vec2{solid.mesh.points[v].x, solid.mesh.points[v].y}) < 5) continue;
        EXPECT_GE(found.evidence[v], 0);
    }
    const ContourSet exact = cylinder(10);
    const SurfaceUncertainty sure =
        surface_uncertainty(exact, left_out(exact), solid.mesh, solid.regions, context);
    for (std::size_t v = 0; v < solid.mesh.points.size(); ++v) {
        const Vec3 p = solid.mesh.points[v];
        if (length(Vec2{p.x, p.y}) < 5) continue;
        const double to_slice = std::abs(p.z - 2 * std::round(0.5 * p.z));
        EXPECT_NEAR(sure.evidence[v], to_slice, 0.1);
        if (p.z > 5 && p.z < 13) {
            EXPECT_NEAR(sure.expected[v], 0, 1e-4);
        }
    }
}

TEST(WhereNext, names_the_missing_slice_first) {
    const ContourSet set = cylinder(10, 0.005, 4);
    const Tube solid = tube(18);
    RunContext context;
    const SurfaceUncertainty uncertainty =
        surface_uncertainty(set, left_out(set), solid.mesh, solid.regions, context);
    const WhereNext next = where_next(set, uncertainty, solid.mesh, solid.regions, {3});
    ASSERT_FALSE(next.planes.empty());
    EXPECT_EQ(next.planes.front().slice_a, 3);
    EXPECT_EQ(next.planes.front().slice_b, 4);
    EXPECT_NEAR(next.planes.front().plane.origin.z, 8, 1e-9);
    double gain = 0;
    for (std::size_t n = 0; n < next.planes.size(); ++n) {
        if (n > 0) {
            EXPECT_LE(next.planes[n].gain_mm3, next.planes[n - 1].gain_mm3 * (1 + 1e-9));
        }
        gain += next.planes[n].gain_mm3;
    }
    EXPECT_LE(gain, next.expected_mm3);
}

}  // namespace
}  // namespace anatomesh
