#include "anatomesh/live/draw/reshape.h"

#include <gtest/gtest.h>

#include "anatomesh/live/draw/area/draw_fixtures.h"
#include "anatomesh/live/draw/stroke.h"

namespace anatomesh::reshape_test {
namespace {

using namespace draw_fixtures;

constexpr double pi = std::numbers::pi;

DrawResult reshaped(const StructureRings& before, std::span<const Vec2> line, std::vector<Vec2> clip = {}) {
    StrokeOptions options;
    options.mode = DrawMode::reshape;
    options.clip = std::move(clip);
    Result<DrawResult> result = draw_stroke(before, line, options);
    EXPECT_TRUE(result.ok());
    expect_sound(result.value().rings);
    return result.value();
}

// An arc about the origin, with the radius as a function of the share of the arc.
template <class Radius>
Polygon arc(double from, double to, const Radius& radius) {
    Polygon line;
    for (int n = 0; n <= 60; ++n) {
        const double share = n / 60.0, angle = from + share * (to - from);
        line.push_back(radius(share) * Vec2{std::cos(angle), std::sin(angle)});
    }
    return line;
}

// Lines that begin and end near a circle and bulge out or in between: the outline is the line there, and as it was
// elsewhere, whatever the direction of ring and line.
TEST(Reshape, the_line_is_the_outline_between_its_ends) {
    for (int seed = 0; seed < 300; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Plane plane = random_plane(random);
        Polygon outline = circle({0, 0}, 30, 200, uniform(random, 0, 6));
        if (random() % 2) std::reverse(outline.begin(), outline.end());
        const StructureRings before = rings_of({outline}, plane);
        const double from = uniform(random, 0, 6), width = uniform(random, 0.3, 2.6),
                     bulge = uniform(random, -12, 12);
        const double off_start = uniform(random, -1.5, 1.5), off_end = uniform(random, -1.5, 1.5);
        const auto radius = [&](double share) {
            return 30 + off_start * (1 - share) + off_end * share + bulge * std::sin(pi * share);
        };
        Polygon line = arc(from, from + width, radius);
        if (random() % 2) std::reverse(line.begin(), line.end());
        const DrawResult result = reshaped(before, line);
        ASSERT_EQ(result.effect, AreaEffect::reshaped) << seed;
        for (int n = 0; n < 300; ++n) {
            const double share = uniform(random, 0.1, 0.9), inner = uniform(random, 5, 45);
            const double angle = from + share * width,
                         elsewhere = from + width + 0.15 + share * (2 * pi - width - 0.3);
            const Vec2 p = inner * Vec2{std::cos(angle), std::sin(angle)};
            if (distance_to_path(line, p) > 0.06) {
                ASSERT_EQ(encloses(result.rings.rings, p), inner < radius(share)) << seed;
            }
            if (std::abs(inner - 30) > 0.01) {
                ASSERT_EQ(
                    encloses(result.rings.rings, inner * Vec2{std::cos(elsewhere), std::sin(elsewhere)}),
                    inner < 30)
                    << seed;
            }
        }
        // The rest of the ring keeps its bytes, in its direction.
        std::vector<Vec3> rest;
        for (std::size_t k = 0, start = 0; k < 2 * outline.size(); ++k) {
            const double angle = std::atan2(outline[k % 200].y, outline[k % 200].x) - from;
            const bool is_far = std::fmod(angle + 4 * pi, 2 * pi) > width + 0.15 &&
                                std::fmod(angle + 4 * pi, 2 * pi) < 2 * pi - 0.15;
            if (!is_far && start == 0) start = k + 1;
            if (start == 0) continue;
            if (is_far) rest.push_back(before.rings[0].points[k % 200]);
            if (!is_far && !rest.empty()) break;
        }
        const auto has = [&](const Ring& ring) { return has_stretch(ring.points, rest); };
        EXPECT_TRUE(std::any_of(result.rings.rings.begin(), result.rings.rings.end(), has)) << seed;
    }
}

TEST(Reshape, a_line_through_cuts_off_the_smaller_side) {
    const StructureRings before = rings_of({circle({0, 0}, 30, 200)}, {});
    for (const double x : {-20.0, -3.0, 3.0, 12.0, 29.0}) {
        const DrawResult result = reshaped(before, Polygon{{x, -50}, {x, 50}});
        EXPECT_EQ(result.effect, AreaEffect::reshaped);
        ASSERT_EQ(result.rings.rings.size(), 1u);
        const double angle = std::acos(std::abs(x) / 30),
                     segment = 900 * (angle - std::sin(angle) * std::cos(angle));
        EXPECT_NEAR(area_of(result.rings), 900 * pi - segment, 2) << x;
    }
}

TEST(Reshape, at_a_hole_is_the_other_way_round) {
    const StructureRings before = rings_of({circle({0, 0}, 40, 200), circle({0, 0}, 20, 100)}, {});
    const DrawResult larger =
        reshaped(before, arc(0, 1, [](double s) { return 20 + 10 * std::sin(pi * s); }));
    EXPECT_LT(area_of(larger.rings), area_of(before) - 50);
    EXPECT_EQ(larger.rings.rings[0].points, before.rings[0].points);
    const DrawResult smaller =
        reshaped(before, arc(0, 1, [](double s) { return 20 - 10 * std::sin(pi * s); }));
    EXPECT_GT(area_of(smaller.rings), area_of(before) + 50);
    EXPECT_EQ(smaller.rings.rings.size(), 2u);
    // Beyond the outline: the hole opens.
    const DrawResult open = reshaped(before, arc(0, 1, [](double s) { return 20 + 40 * std::sin(pi * s); }));
    EXPECT_EQ(open.rings.rings.size(), 1u);
}

TEST(Reshape, over_another_part_joins_it) {
    const StructureRings before = rings_of({circle({0, 0}, 20, 100), circle({50, 0}, 10, 60)}, {});
    const DrawResult joined = reshaped(before, Polygon{{19, 6}, {50, 3}, {50, -3}, {19, -6}});
    EXPECT_EQ(joined.rings.rings.size(), 1u);
    EXPECT_GT(area_of(joined.rings), area_of(before));
}

TEST(Reshape, needs_an_outline_at_both_ends) {
    const StructureRings before = rings_of({circle({0, 0}, 20, 100)}, {});
    EXPECT_EQ(reshaped(before, Polygon{{60, 0}, {90, 10}}).reason, NothingDrawn::no_outline);
    EXPECT_EQ(reshaped(before, Polygon{{20, 0}, {90, 10}}).reason, NothingDrawn::no_outline);
    EXPECT_EQ(reshaped(before, Polygon{{0, 0}, {90, 10}}).reason, NothingDrawn::no_outline);
    EXPECT_EQ(reshaped({}, Polygon{{60, 0}, {90, 10}}).reason, NothingDrawn::no_outline);
}

TEST(Reshape, grows_within_the_picture_alone) {
    const StructureRings before = rings_of({circle({0, 0}, 20, 100)}, {});
    const std::vector<Vec2> clip{{-40, -40}, {25, -40}, {25, 40}, {-40, 40}};
    const DrawResult result =
        reshaped(before, arc(-0.8, 0.8, [](double s) { return 20 + 15 * std::sin(pi * s); }), clip);
    EXPECT_TRUE(result.is_clipped);
    for (const Vec2 p : result.rings.rings[0].at) EXPECT_LT(p.x, 25 + 1e-6);
    EXPECT_GT(area_of(result.rings), area_of(before) + 50);
}

}  // namespace
}  // namespace anatomesh::reshape_test
