#include "anatomesh/reconcile/move/common_lines.h"

#include <gtest/gtest.h>

#include <numbers>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh/reconcile/reconcile.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh::common_lines_test {
namespace {

using fixtures::Ring;
using fixtures::SetBuilder;

constexpr double pi = std::numbers::pi;

// The plane through the z axis on which x runs away from it at an angle, y along it.
Plane about_z(double angle) {
    const Vec3 out{std::cos(angle), std::sin(angle), 0}, up{0, 0, 1};
    return {{}, out, up, cross(out, up)};
}

// Half of an ellipsoid of revolution, its flat side in the axis about which the planes turn; there every
// slice has vertices at heights of its own.
ContourSet half_ellipsoid(int planes, double rounded) {
    SetBuilder builder;
    for (int k = 0; k < planes; ++k) {
        builder.slice(about_z(pi * (k + 0.5) / planes));
        Ring ring;
        const auto digits = [&](double x) { return rounded > 0 ? rounded * std::round(x / rounded) : x; };
        for (int n = 0; n <= 24; ++n) {
            const double t = pi * (n / 24.0 - 0.5);
            ring.push_back({digits(18 * std::cos(t)), digits(25 * std::sin(t))});
        }
        for (double y = 24 - 0.37 * (k % 4); y > -24.5; y -= 1.7) ring.push_back({0, digits(y)});
        builder.ring(0, ring);
    }
    return builder.set;
}

// Heights of a slice's vertices on the axis, rising.
std::vector<double> on_axis(const ContourSet& set, std::uint32_t slice) {
    std::vector<double> heights;
    for (const Contour& contour : set.contours_of(set.slices[slice])) {
        for (const Vec3& p : set.points_of(contour)) {
            if (std::hypot(p.x, p.y) < 0.02) heights.push_back(p.z);
        }
    }
    std::sort(heights.begin(), heights.end());
    return heights;
}

TEST(CommonLines, slices_with_a_side_in_their_axis_have_the_same_vertices_there) {
    for (const double rounded : {0.0, 0.01}) {
        ContourSet set = half_ellipsoid(9, rounded);
        const ContourSet before = set;
        const auto pairs = crossing_pairs(plane_patches(set), 1);
        const CommonLineStats stats = lead_along_common_lines(set, pairs, {});
        EXPECT_GT(stats.led_through, 0u);
        EXPECT_LE(stats.farthest_mm, 0.01);
        for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
            EXPECT_EQ(on_axis(set, s), on_axis(set, 0)) << s;
            // All that was there is there, and nothing else has changed.
            for (const Contour& contour : before.contours_of(before.slices[s])) {
                for (const Vec3& p : before.points_of(contour)) {
                    double nearest = 1;
                    for (const Vec3& q : set.points_of(set.contours[s]))
                        nearest = std::min(nearest, length(p - q));
                    EXPECT_LE(nearest, std::hypot(p.x, p.y) < 0.02 ? 0.01 : 0);
                }
            }
        }
        EXPECT_EQ(lead_along_common_lines(set, pairs, {}).led_through, 0u);
    }
}

TEST(CommonLines, contours_that_cross_the_line_are_left_alone) {
    SetBuilder builder;
    for (int k = 0; k < 6; ++k) {
        builder.slice(about_z(pi * k / 6));
        builder.ring(0, fixtures::circle({}, 20, 60));
    }
    const ContourSet before = builder.set;
    const auto pairs = crossing_pairs(plane_patches(builder.set), 1);
    const CommonLineStats stats = lead_along_common_lines(builder.set, pairs, {});
    EXPECT_EQ(stats.led_through + stats.moved, 0u);
    EXPECT_EQ(builder.set.points, before.points);
}

// C27: points on the axis merged.
TEST(CommonLines, C27_half_an_organ_cut_along_the_axis_is_modelled) {
    RunContext context;
    auto reconciled = reconcile_contours(half_ellipsoid(9, 0.001), {}, context);
    ASSERT_TRUE(reconciled.ok());
    const auto made = build_model(reconciled.value().kept, {}, context);
    ASSERT_TRUE(made.ok()) << to_line(made.error());
    const StructureReport& structure = made.value().report.structures[0];
    EXPECT_EQ(structure.surface.components, 1u);
    EXPECT_EQ(structure.surface.genus, 0);
    EXPECT_NEAR(structure.volume.mesh_mm3 / (2.0 / 3 * pi * 18 * 18 * 25), 1, 0.02);
    EXPECT_LE(structure.fidelity.segments - structure.fidelity.segments_on_surface, 2u);
}

}  // namespace
}  // namespace anatomesh::common_lines_test
