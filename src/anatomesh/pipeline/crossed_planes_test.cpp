// Laws of models of a stack with planes across it: what a plane leaves out, and planes that agree.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "anatomesh/pipeline/solid_fixtures_for_test.h"
#include "anatomesh/reconcile/reconcile.h"
#include "anatomesh/reconcile/reconcile_fixtures_for_test.h"

namespace anatomesh::crossed_planes_test {
namespace {

using namespace fixtures;

// A ball of 18 mm with a hollow one of 9 mm, which is structure 1, on slices 2.2 mm apart and on planes along
// z; `draws(n, structure)`: whether the n-th of these draws it.
ContourSet ball_in_a_ball(int along, const std::function<bool(int, int)>& draws) {
    ContourSet set;
    set.source = "fixture";
    set.structures = {{1, "outer", {}}, {2, "inner", {}}};
    std::vector<Plane> planes;
    for (int k = -8; k <= 8; ++k) planes.push_back(make_plane({0, 0, 2.2 * k}, {0, 0, 1}));
    for (int n = 0; n < along; ++n) {
        const double angle = 0.2 + std::numbers::pi * n / along;
        planes.push_back(make_plane({0.3, 0.2, 0}, {std::cos(angle), std::sin(angle), 0}));
    }
    for (std::uint32_t s = 0; s < planes.size(); ++s) {
        const Plane& plane = planes[s];
        set.slices.push_back({plane, static_cast<std::uint32_t>(set.contours.size()), 0, std::to_string(s)});
        const double h = plane.signed_distance({});
        const auto ring = [&](std::uint32_t structure, double radius, bool is_hole) {
            const double r2 = radius * radius - h * h;
            if (r2 <= 0 || (s >= 17 && !draws(static_cast<int>(s) - 17, static_cast<int>(structure)))) return;
            const int count = std::max(12, static_cast<int>(2 * std::numbers::pi * std::sqrt(r2)));
            std::vector<Vec3> points;
            for (int i = 0; i < count; ++i) {
                const double angle = 2 * std::numbers::pi * i / count;
                points.push_back(plane.to_space(plane.to_plane({}) +
                                                std::sqrt(r2) * Vec2{std::cos(angle), std::sin(angle)}));
            }
            if (is_hole) std::reverse(points.begin(), points.end());
            std::rotate(points.begin(),
                        std::min_element(points.begin(), points.end(),
                                         [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); }),
                        points.end());
            set.contours.push_back({structure, s, static_cast<std::uint32_t>(set.points.size()),
                                    static_cast<std::uint32_t>(count)});
            set.points.insert(set.points.end(), points.begin(), points.end());
            ++set.slices.back().contour_count;
        };
        ring(0, 18, false);
        ring(0, 9, true);
        ring(1, 9, false);
    }
    return set;
}

TEST(CrossedPlanes, a_plane_across_that_leaves_a_structure_out_does_not_cut_it) {
    for (const int along : {1, 2}) {
        for (const int left_out : {0, 1}) {
            const ContourSet drawn =
                ball_in_a_ball(along, [&](int n, int structure) { return n > 0 || structure != left_out; });
            RunContext context;
            ReconcileResult made = reconcile_contours(drawn, {}, context).value();
            EXPECT_EQ(std::count_if(context.warnings.begin(), context.warnings.end(),
                                    [](const Warning& w) { return w.code == "W-RCN-007"; }),
                      1);
            auto model = build(made.kept);
            ASSERT_TRUE(model.ok()) << to_line(model.error());
            expect_certified(model.value(), made.kept);
            const double of_ball = 4.0 / 3 * std::numbers::pi;
            expect_structure(model.value(), 0, {2, 0, of_ball * (18 * 18 * 18 - 9 * 9 * 9), 0.02});
            expect_structure(model.value(), 1, {1, 0, of_ball * 9 * 9 * 9, 0.02});
        }
    }
}

// A ball on three stacks by several hands, in other units.
TEST(CrossedPlanes, C32_models_of_any_size_are_alike) {
    std::mt19937 random(8);
    const ContourSet drawn = crossing_fixtures::drawn_ball(14, crossing_fixtures::three_stacks(12, 4, 0.05),
                                                           {0.5, 0.4, 40}, random);
    const auto model_at = [&](double factor) {
        ContourSet set = drawn;
        for (Vec3& p : set.points) p = factor * p;
        for (Slice& slice : set.slices) slice.plane.origin = factor * slice.plane.origin;
        RunContext context;
        ReconcileOptions options;
        options.max_disagreement_mm *= factor;
        ReconcileResult made = reconcile_contours(set, options, context).value();
        auto model = build(made.kept);
        EXPECT_TRUE(model.ok()) << factor << to_line(model.error());
        expect_certified(model.value(), made.kept);
        return std::move(model).value();
    };
    const Model usual = model_at(1);
    for (const double factor : {2.0, 16.0}) {
        std::vector<Vec3> points = usual.mesh.points;
        for (Vec3& p : points) p = factor * p;
        const Model other = model_at(factor);
        EXPECT_EQ(other.mesh.cells, usual.mesh.cells) << factor;
        EXPECT_EQ(other.mesh.points, points) << factor;
    }
    for (const double factor : {1.0 / 40, 1.0 / 32, 25.0}) {
        const Model other = model_at(factor);
        EXPECT_EQ(other.report.structures[0].surface.components, 1u) << factor;
        EXPECT_EQ(other.report.structures[0].surface.genus, 0) << factor;
        EXPECT_NEAR(static_cast<double>(other.mesh.cells.size()),
                    static_cast<double>(usual.mesh.cells.size()),
                    0.15 * static_cast<double>(usual.mesh.cells.size()))
            << factor;
    }
}

}  // namespace
}  // namespace anatomesh::crossed_planes_test
