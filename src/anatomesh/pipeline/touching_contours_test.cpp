// Laws of structures whose contours touch, run along each other in part, or leave each other at small angles.
#include <gtest/gtest.h>

#include <cmath>

#include "anatomesh/contour/walls/merge_coincident.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh::touching_contours_test {
namespace {

using namespace fixtures;

// Two blocks, one on the side of the other, which it touches from `from` on and leaves at an angle; turned,
// and in the digits of a file.
Drawing blocks(double from, double degrees, double turn) {
    Drawing drawing;
    const double rise = 4.3 * std::tan(degrees * pi / 180);
    for (int z = 0; z < 8; ++z) {
        drawing.add(0, z, rectangle({0, 0}, {8, 6}));
        drawing.add(1, z, {{from, 6}, {from + 4.3, 6 + rise}, {from + 4.3, 11}, {from, 11}});
    }
    drawing.move([&](Vec3 p) {
        const auto digits = [](double x) { return std::round(1e6 * x) / 1e6; };
        return Vec3{digits(std::cos(turn) * p.x - std::sin(turn) * p.y),
                    digits(std::sin(turn) * p.x + std::cos(turn) * p.y), p.z};
    });
    return drawing;
}

// Nearly all: a subsegment or two a model is given up for a manifold's sake.
TEST(TouchingContours, that_share_walls_in_part_or_leave_each_other_keep_their_segments) {
    std::size_t all_missed = 0;
    for (const double degrees : {0.0, 4.0, 9.0, 20.0}) {
        for (const double from : {0.15, 2.0, 3.7}) {
            for (const double turn : {0.0, 0.3}) {
                SCOPED_TRACE(testing::Message() << degrees << " degrees from " << from << " turned " << turn);
                const auto made = build(kept(blocks(from, degrees, turn).raw));
                ASSERT_TRUE(made.ok()) << to_line(made.error());
                std::size_t missed = 0;
                for (const StructureReport& structure : made.value().report.structures) {
                    missed += structure.fidelity.segments - structure.fidelity.segments_on_surface;
                    EXPECT_EQ(structure.surface.components, 1u);
                    EXPECT_EQ(structure.surface.genus, 0);
                }
                EXPECT_LE(missed, 2u);
                all_missed += missed;
            }
        }
    }
    EXPECT_LE(all_missed, 8u);  // of 1536
}

// One organ drawn twice: an outline and another one that winds about it, 0.1 to 0.5 mm off, in the digits of
// a file.
Drawing drawn_twice(double off) {
    Drawing drawing;
    constexpr int corners = 80;
    for (int k = 1; k < 5; ++k) {
        const double z = 6 * k - 15, shrink = std::sqrt(1 - z * z / 900);
        for (std::uint32_t s = 0; s < 2; ++s) {
            Polygon outline;
            for (int n = 0; n < corners; ++n) {
                const double t = 2 * pi * (n + 0.16 * s) / corners;
                double wave = 0;
                for (int m = 2; m < 10; ++m)
                    wave += s * off * std::sin(m * t + 1.7 * m + 0.08 * (m - 1) * z) / 2.8;
                const auto digits = [](double x) { return std::round(100 * x) / 100; };
                outline.push_back(
                    {digits((30 * shrink + wave) * std::cos(t)), digits((24 * shrink + wave) * std::sin(t))});
            }
            drawing.add(s, z, outline);
        }
    }
    return drawing;
}

TEST(TouchingContours, of_an_organ_drawn_twice_keep_all_segments) {
    for (const double off : {0.3, 1.0}) {
        SCOPED_TRACE(testing::Message() << off << " mm off");
        ContourSet set = kept(drawn_twice(off).raw);
        merge_coincident(set, {});
        const auto made = build(set);
        ASSERT_TRUE(made.ok()) << to_line(made.error());
        for (const StructureReport& structure : made.value().report.structures) {
            EXPECT_EQ(structure.fidelity.segments, structure.fidelity.segments_on_surface);
            EXPECT_EQ(structure.surface.components, 1u);
            EXPECT_EQ(structure.surface.genus, 0);
        }
    }
}

// A circle whose line crosses itself and goes on in a triangle `deep` beyond it, 2 * `half` wide there: an
// island that touches it. `deep` below 0: round what is inside already, which is a hole then.
Drawing crossing_itself(double half, double deep) {
    Drawing drawing;
    for (int k = 0; k < 8; ++k) {
        Polygon outline;
        for (int n = 0; n < 40; ++n) {
            const double t = 2 * pi * n / 40;
            if (n != 20) {
                outline.push_back({15 * std::cos(t), 15 * std::sin(t)});
                continue;
            }
            outline.push_back({-15 - deep, -half});
            outline.push_back({-15 - deep, half});
        }
        drawing.add(0, 3 * k, outline);
    }
    return drawing;
}

TEST(TouchingContours, C04_of_a_line_that_crosses_itself_are_parted_or_closed) {
    for (const double half : {0.3, 1.0, 2.0}) {
        for (const double deep : {-6.0, -3.0, -1.0, 3.0, 6.0}) {
            SCOPED_TRACE(testing::Message() << half << " wide, " << deep << " deep");
            const ContourSet set = kept(crossing_itself(half, deep).raw);
            const auto made = build(set);
            ASSERT_TRUE(made.ok()) << to_line(made.error());
            expect_certified(made.value(), set);
            // A slip of the pen is closed; a larger loop is a piece, or a hole through all slices.
            const bool closed = set.contours.size() == 8;
            EXPECT_EQ(closed, half < 1 || (half == 1 && std::abs(deep) < 6) || deep == -1);
            const StructureReport& structure = made.value().report.structures[0];
            EXPECT_EQ(structure.surface.components, closed || deep < 0 ? 1u : 2u);
            EXPECT_EQ(structure.surface.genus, closed || deep > 0 ? 0 : 1);
            EXPECT_EQ(structure.fidelity.segments, structure.fidelity.segments_on_surface);
        }
    }
}

// Two cylinders that touch in one vertex of every second slice, on which alone the second one is drawn.
Drawing cylinders_that_touch(double radius, int corners) {
    Drawing drawing;
    for (int k = 0; k < 12; ++k) {
        for (std::uint32_t s = 0; s <= (k % 2 == 0 ? 1u : 0u); ++s) {
            Polygon outline;
            for (int n = 0; n < corners; ++n) {
                const double t = 2 * pi * n / corners, middle = s == 0 ? -radius : radius;
                outline.push_back({middle + radius * std::cos(t), radius * std::sin(t)});
            }
            outline[s == 0 ? 0 : static_cast<std::size_t>(corners / 2)] = {0, 0};
            drawing.add(s, 2 * k, outline);
        }
    }
    return drawing;
}

TEST(TouchingContours, in_one_vertex_keep_what_is_drawn_beside_it) {
    for (const double radius : {2.5, 2.8, 3.0, 3.2}) {
        for (const int corners : {20, 24, 28}) {
            SCOPED_TRACE(testing::Message() << radius << " mm, " << corners << " corners");
            const ContourSet set = kept(cylinders_that_touch(radius, corners).raw);
            const auto made = build(set);
            ASSERT_TRUE(made.ok()) << to_line(made.error());
            expect_certified(made.value(), set);
            for (const Clause& clause : made.value().report.certificate)
                EXPECT_EQ(clause.state, ClauseState::kept) << clause.number << ": " << clause.evidence;
            for (const StructureReport& structure : made.value().report.structures) {
                EXPECT_EQ(structure.surface.components, 1u);
                EXPECT_EQ(structure.surface.genus, 0);
                EXPECT_EQ(structure.fidelity.segments, structure.fidelity.segments_on_surface);
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::touching_contours_test
