#include <gtest/gtest.h>

#include <cmath>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/uncertainty/gap_doubts.h"
#include "anatomesh/uncertainty/left_out.h"
#include "anatomesh/uncertainty/surface_uncertainty.h"
#include "anatomesh/uncertainty/where_next.h"

namespace anatomesh::uncertainty_test {
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
    const WhereNext next = where_next(set, uncertainty, solid.mesh, solid.regions, {3, {}});
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

// A wavy tube with slices missing in the middle, about any axis: the stack at the heights of `at`.
ContourSet with_gap(const std::vector<double>& at, Vec3 normal) {
    SetBuilder builder;
    for (const double z : at) {
        builder.slice(make_plane(z * normalized(normal), normal));
        builder.ring(0, circle({}, 10 + 2 * std::sin(0.3 * z), 60));
    }
    return builder.set;
}

std::vector<double> heights_with_gap(int before, int missing, int after, double spacing) {
    std::vector<double> at;
    for (int k = 0; k < before + missing + after; ++k) {
        if (k < before || k >= before + missing) at.push_back(spacing * k);
    }
    return at;
}

TEST(WhereNext, names_the_middle_of_an_open_gap_first) {
    for (const double spacing : {1.0, 3.0}) {
        for (int missing = 2; missing <= 7; ++missing) {
            for (const auto& [before, after] : {std::pair{3, 9}, {6, 6}, {10, 4}}) {
                const ContourSet set = with_gap(heights_with_gap(before, missing, after, spacing), {0, 0, 1});
                const Tube solid = tube(spacing * (before - 0.5));  // up to the gap
                RunContext context;
                const SurfaceUncertainty uncertainty =
                    surface_uncertainty(set, left_out(set), solid.mesh, solid.regions, context);
                const WhereNext next = where_next(set, uncertainty, solid.mesh, solid.regions, {1, {}});
                ASSERT_EQ(next.planes.size(), 1u);
                const NextPlane& first = next.planes.front();
                EXPECT_EQ(first.slice_a, before - 1);
                EXPECT_EQ(first.slice_b, before);
                EXPECT_NEAR(first.plane.origin.z, spacing * (before + 0.5 * (missing - 1)), 1e-9);
                EXPECT_GT(first.gap_mm3, 0);
                EXPECT_LE(first.gap_mm3, next.gaps_mm3);
                EXPECT_LE(next.gaps_mm3, next.expected_mm3);
            }
        }
    }
}

// Whatever the axis, a plane half-way takes more than any other.
TEST(GapDoubts, are_least_with_a_plane_half_way) {
    for (int missing = 2; missing <= 9; ++missing) {
        for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 2, 3}}) {
            const Vec3 up = normalized(normal);
            const GapDoubts doubts(with_gap(heights_with_gap(5, missing, 4, 2), normal), {});
            ASSERT_EQ(doubts.middles().size(), 1u);
            const PlaneBetween middle = doubts.middles().front();
            const double low = 8, high = 8 + 2 * (missing + 1);
            EXPECT_EQ(middle.slice_a, 4);
            EXPECT_EQ(middle.slice_b, 5);
            EXPECT_NEAR(dot(middle.plane.origin, up), 0.5 * (low + high), 1e-9);
            std::vector<double> unused(1, 0);
            const double most = doubts.gain(middle.plane.origin, unused);
            for (double z = low - 3; z < high + 3; z += 0.1) {
                const double gain = doubts.gain(z * up, unused);
                EXPECT_GE(gain, 0);
                EXPECT_LE(gain, most * (1 + 1e-12));
                if (z < low || z > high) {
                    EXPECT_EQ(gain, 0);
                }
            }
        }
    }
}

// However many planes it takes until the sides are joined, they take all of the doubt away, and no more
// planes are named for it; joined sides have none.
TEST(GapDoubts, is_taken_away_by_halving_the_gap) {
    for (int missing = 1; missing <= 12; ++missing) {
        for (const double max_gap : {1.0, 2.0, 3.5, 20.0}) {
            const ContourSet set = with_gap(heights_with_gap(5, missing, 6, 2), {0, 0, 1});
            FieldOptions options;
            options.max_gap_spacings = max_gap;
            GapDoubts doubts(set, options);
            EXPECT_EQ(doubts.volume() > 0, missing + 1 > max_gap) << missing << ' ' << max_gap;
            double left = doubts.volume();
            for (int planes = 0; planes < 31 && !doubts.middles().empty(); ++planes) {
                std::vector<double> by_structure(set.structures.size(), 0);
                const Vec3 middle = doubts.middles().front().plane.origin;
                const double gain = doubts.gain(middle, by_structure);
                EXPECT_GT(gain, 0);
                EXPECT_NEAR(by_structure[0], gain, 1e-9);
                doubts.draw(middle);
                left -= gain;
                EXPECT_NEAR(doubts.volume(), left, 1e-6);
            }
            EXPECT_TRUE(doubts.middles().empty());
            EXPECT_NEAR(left, 0, 1e-6);
        }
    }
}

// Slices that lean against each other: the plane leans as much as half of those beside it.
TEST(GapDoubts, of_a_sweep_is_in_its_gap) {
    const double lean = 0.02;
    SetBuilder builder;
    for (int k = 0; k < 16; ++k) {
        if (k >= 6 && k < 10) continue;
        const double angle = lean * k;
        const Vec3 normal{0, std::sin(angle), std::cos(angle)};
        builder.slice(make_plane({0, -60 * std::cos(angle), 60 * std::sin(angle)}, normal));
        builder.ring(0, circle({0, 0}, 10, 60));
    }
    const GapDoubts doubts(builder.set, {});
    ASSERT_EQ(doubts.middles().size(), 1u);
    const PlaneBetween middle = doubts.middles().front();
    EXPECT_EQ(middle.slice_a, 5);
    EXPECT_EQ(middle.slice_b, 6);
    const double angle = lean * 7.5;
    EXPECT_NEAR(dot(middle.plane.normal, Vec3{0, std::sin(angle), std::cos(angle)}), 1, 1e-9);
    EXPECT_NEAR(middle.plane.signed_distance({0, 0, 0}), 0, 0.1);
}

}  // namespace
}  // namespace anatomesh::uncertainty_test
