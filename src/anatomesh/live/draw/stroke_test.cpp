#include "anatomesh/live/draw/stroke.h"

#include <gtest/gtest.h>

#include "anatomesh/live/draw/area/draw_fixtures.h"

namespace anatomesh::stroke_test {
namespace {

using namespace draw_fixtures;

constexpr double pi = std::numbers::pi;

DrawResult drawn(const StructureRings& before, std::span<const Vec2> stroke,
                 DrawMode mode = DrawMode::automatic, StrokeOptions options = {}) {
    options.mode = mode;
    Result<DrawResult> result = draw_stroke(before, stroke, options);
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : to_line(result.error()));
    if (!result.ok()) return {};
    expect_sound(result.value().rings);
    EXPECT_EQ(result.value().effect == AreaEffect::nothing, result.value().reason != NothingDrawn::none);
    return result.value();
}

StructureRings disc(double radius = 30) {
    return rings_of({circle({0, 0}, radius, 200)}, {});
}

TEST(Stroke, is_the_operation_of_sets_for_random_hands) {
    int effects[6] = {};
    for (int seed = 0; seed < 200; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Plane plane = random_plane(random);
        const StructureRings before = random_rings(random, plane);
        const Vec2 start{uniform(random, -20, 80), uniform(random, -20, 80)};
        const Polygon stroke = random_path(random, start, whole(random, 20, 150), 1, 0.1);
        StrokeOptions options;
        options.tolerance_mm = 0.02;
        const Polygon meant = without_tails(stroke);
        const DrawResult result = drawn(before, stroke, DrawMode::automatic, options);
        ++effects[static_cast<int>(result.effect)];
        const bool begins_inside = encloses(before.rings, start);
        EXPECT_FALSE(begins_inside && result.effect == AreaEffect::cut);
        for (int n = 0; n < 200; ++n) {
            const Vec2 p{uniform(random, -60, 120), uniform(random, -60, 120)};
            const Ring line = ring_of(meant, plane);
            if (distance_to_rings(before.rings, p) < 0.05 || distance_to_rings(std::span(&line, 1), p) < 0.05)
                continue;
            const bool was = encloses(before.rings, p), in = encloses(meant, p);
            const bool expected = result.effect == AreaEffect::cut ? was && !in : was || in;
            ASSERT_EQ(encloses(result.rings.rings, p), expected) << seed;
        }
    }
    EXPECT_GT(effects[static_cast<int>(AreaEffect::cut)], 10);
    EXPECT_GT(effects[static_cast<int>(AreaEffect::extended)], 10);
    EXPECT_GT(effects[static_cast<int>(AreaEffect::new_part)], 10);
}

TEST(Stroke, automatic_extends_from_inside_cuts_from_outside_and_draws_beside) {
    const StructureRings before = disc();
    const DrawResult extended = drawn(before, circle({30, 0}, 10, 60, pi));
    EXPECT_EQ(extended.effect, AreaEffect::extended);
    EXPECT_GT(area_of(extended.rings), area_of(before) + 100);
    const DrawResult cut = drawn(before, circle({30, 0}, 10, 60));
    EXPECT_EQ(cut.effect, AreaEffect::cut);
    EXPECT_LT(area_of(cut.rings), area_of(before) - 100);
    const DrawResult beside = drawn(before, circle({60, 0}, 10, 60));
    EXPECT_EQ(beside.effect, AreaEffect::new_part);
    EXPECT_EQ(beside.rings.rings.size(), 2u);
    EXPECT_EQ(beside.rings.rings[0].points, before.rings[0].points);
    const DrawResult first = drawn({}, circle({60, 0}, 10, 60));
    EXPECT_EQ(first.effect, AreaEffect::new_part);
    // On a hole alone: an island.
    const StructureRings annulus = rings_of({circle({0, 0}, 30, 90), circle({0, 0}, 20, 60)}, {});
    EXPECT_EQ(drawn(annulus, circle({0, 0}, 5, 60)).effect, AreaEffect::new_part);
}

TEST(Stroke, modes_do_what_they_say) {
    const StructureRings before = disc();
    const Polygon over = circle({30, 0}, 10, 60);
    EXPECT_EQ(drawn(before, over, DrawMode::extend).effect, AreaEffect::extended);
    EXPECT_EQ(drawn(before, over, DrawMode::cut).effect, AreaEffect::cut);
    const DrawResult replaced = drawn(before, over, DrawMode::replace);
    EXPECT_EQ(replaced.effect, AreaEffect::replaced);
    EXPECT_NEAR(area_of(replaced.rings), 100 * pi, 3);
    EXPECT_EQ(drawn(before, circle({90, 0}, 10, 60), DrawMode::cut).reason, NothingDrawn::nothing_there);
    EXPECT_EQ(drawn(before, circle({0, 0}, 10, 60), DrawMode::extend).reason, NothingDrawn::nothing_there);
}

// A hand draws a circle whose end passes its start by, or falls short of it, inside or outside.
TEST(Stroke, a_circle_of_a_free_hand_is_one_ring) {
    for (int seed = 0; seed < 300; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const double turns = uniform(random, 0.95, 1.06), drift = uniform(random, -1.5, 1.5);
        const double phase = uniform(random, 0, 6), from = uniform(random, 0, 6);
        Polygon stroke;
        for (int n = 0; n <= 200; ++n) {
            const double share = n / 200.0, angle = from + 2 * pi * turns * share;
            const double radius = 20 + drift * share + 0.3 * std::sin(3 * angle + phase);
            stroke.push_back(radius * Vec2{std::cos(angle), std::sin(angle)});
        }
        if (random() % 2) std::reverse(stroke.begin(), stroke.end());
        const DrawResult result = drawn({make_plane({1, 2, 3}, {0.1, 0.2, 1}), {}}, stroke);
        ASSERT_EQ(result.rings.rings.size(), 1u) << seed;
        EXPECT_EQ(result.mended_crossings, 0u) << seed;
        EXPECT_NEAR(area_of(result.rings), 400 * pi, 0.1 * 400 * pi) << seed;
    }
}

TEST(Stroke, an_eight_is_two_rings_and_a_star_has_no_middle) {
    Polygon eight;
    for (int n = 0; n <= 400; ++n) {
        const double angle = 2 * pi * n / 200;
        eight.push_back(n <= 200 ? Vec2{20 * std::cos(angle) - 20, 20 * std::sin(angle)}
                                 : Vec2{20 - 20 * std::cos(angle), 20 * std::sin(angle)});
    }
    for (std::size_t start : {0u, 37u, 200u, 311u}) {
        Polygon turned(eight.begin(), eight.end() - 1);
        std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(start), turned.end());
        const DrawResult result = drawn({}, turned);
        EXPECT_EQ(result.rings.rings.size(), 2u);
        EXPECT_NEAR(area_of(result.rings), 2 * pi * 400, 0.01 * 2 * pi * 400);
    }
    // Two circles that cross: their common part is outside.
    const double step = 4 * pi / 5;
    Polygon star;
    for (int n = 0; n < 5; ++n) star.push_back({30 * std::cos(n * step), 30 * std::sin(n * step)});
    const DrawResult result = drawn({}, star);
    EXPECT_NEAR(area_of(result.rings), 0.77568 * 900, 0.01 * 0.77568 * 900);
    EXPECT_EQ(result.rings.rings.size(), 5u);
    EXPECT_EQ(result.mended_crossings, 5u);
}

TEST(Stroke, a_click_or_a_jitter_draws_nothing) {
    const StructureRings before = disc();
    for (const DrawMode mode :
         {DrawMode::automatic, DrawMode::extend, DrawMode::cut, DrawMode::replace, DrawMode::reshape}) {
        for (int seed = 0; seed < 50; ++seed) {
            Random random(static_cast<unsigned>(seed));
            Polygon jitter;
            const int points = whole(random, 0, 40);
            for (int n = 0; n < points; ++n)
                jitter.push_back({29 + uniform(random, 0, 1), uniform(random, 0, 1)});
            const DrawResult result = drawn(before, jitter, mode);  // two pixels of 0.5 mm
            EXPECT_EQ(result.reason, NothingDrawn::too_short);
            EXPECT_TRUE(same_bytes(result.rings, before));
        }
    }
    EXPECT_EQ(drawn(before, Polygon{{0, 0}, {50, 0}}).reason, NothingDrawn::no_area);
    EXPECT_EQ(drawn(before, Polygon{{0, 0}, {50, 0}, {0, 0}}).reason, NothingDrawn::no_area);
    EXPECT_EQ(drawn(before, Polygon{{0, 0}, {50, 0}, {25, 0}}, DrawMode::extend).reason,
              NothingDrawn::no_area);
}

TEST(Stroke, is_clipped_at_the_edge_of_the_picture) {
    StrokeOptions options;
    options.clip = {{0, 0}, {100, 0}, {100, 80}, {0, 80}};
    for (int seed = 0; seed < 100; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Plane plane = random_plane(random);
        Polygon stroke = random_star(random, {uniform(random, -20, 120), uniform(random, -20, 100)}, 25);
        stroke.push_back(stroke[0]);
        const DrawResult result = drawn({plane, {}}, stroke, DrawMode::extend, options);
        bool leaves = false;
        for (const Vec2 p : stroke) leaves = leaves || p.x < 0 || p.x > 100 || p.y < 0 || p.y > 80;
        EXPECT_EQ(result.is_clipped, leaves) << seed;
        for (const Ring& ring : result.rings.rings) {
            for (const Vec2 p : ring.at) {
                ASSERT_TRUE(p.x > -1e-6 && p.x < 100 + 1e-6 && p.y > -1e-6 && p.y < 80 + 1e-6) << seed;
            }
        }
        for (int n = 0; n < 200; ++n) {
            const Vec2 p{uniform(random, 0, 100), uniform(random, 0, 80)};
            const Ring line = ring_of(stroke, plane);
            if (distance_to_rings(std::span(&line, 1), p) < 0.06) continue;
            ASSERT_EQ(encloses(result.rings.rings, p), encloses(stroke, p)) << seed;
        }
    }
    const DrawResult outside = drawn({}, circle({200, 0}, 20, 50), DrawMode::extend, options);
    EXPECT_EQ(outside.reason, NothingDrawn::outside);
    EXPECT_TRUE(outside.is_clipped);
}

TEST(Stroke, refuses_bad_points_and_options) {
    const auto code = [](std::span<const Vec2> stroke, const StrokeOptions& options) {
        const Result<DrawResult> result = draw_stroke({}, stroke, options);
        return result.ok() ? "" : result.error().code;
    };
    const Polygon stroke = circle({0, 0}, 10, 20);
    EXPECT_EQ(code(Polygon{{0, 0}, {1, NAN}, {3, 3}}, {}), "E-LIV-001");
    EXPECT_EQ(code(Polygon{{0, 0}, {1, 2e7}, {3, 3}}, {}), "E-LIV-001");
    StrokeOptions options;
    options.tolerance_mm = 0;
    EXPECT_EQ(code(stroke, options), "E-LIV-008");
    options.tolerance_mm = NAN;
    EXPECT_EQ(code(stroke, options), "E-LIV-008");
    options = {};
    options.clip = {{0, 0}, {10, 10}, {10, 0}, {0, 10}};
    EXPECT_EQ(code(stroke, options), "E-LIV-009");
    options.clip = {{0, 0}, {10, 10}};
    EXPECT_EQ(code(stroke, options), "E-LIV-009");
    options.clip = {{0, 0}, {10, 0}, {2, 2}, {0, 10}};
    EXPECT_EQ(code(stroke, options), "E-LIV-009");
    Polygon star = circle({0, 0}, 10, 5);
    star = {star[0], star[2], star[4], star[1], star[3]};  // turns one way, twice around
    options.clip = star;
    EXPECT_EQ(code(stroke, options), "E-LIV-009");
}

// A scrawl of 1500 long lines crosses itself 190,000 times; no hand draws it, and it must not hold up a program.
TEST(Stroke, refuses_lines_that_cross_too_often) {
    Random random(1);
    Polygon scrawl;
    for (int n = 0; n < 1500; ++n) scrawl.push_back({uniform(random, 0, 100), uniform(random, 0, 100)});
    EXPECT_EQ(draw_stroke({}, scrawl, {}).error().code, "E-LIV-007");
    scrawl.resize(300);
    EXPECT_TRUE(draw_stroke({}, scrawl, {}).ok());
}

}  // namespace
}  // namespace anatomesh::stroke_test
