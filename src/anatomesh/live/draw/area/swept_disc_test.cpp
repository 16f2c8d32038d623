#include "anatomesh/live/draw/area/swept_disc.h"

#include <gtest/gtest.h>

#include <chrono>

#include "anatomesh/live/draw/area/combine_area.h"
#include "anatomesh/live/draw/area/draw_fixtures.h"

namespace anatomesh::swept_disc_test {
namespace {

using namespace draw_fixtures;

constexpr double pi = std::numbers::pi;

std::vector<Ring> swept(std::span<const Vec2> path, double radius, double tolerance = 0.05,
                        const Plane& plane = {}) {
    Result<std::vector<Ring>> result = swept_disc(path, plane, {radius, tolerance});
    EXPECT_TRUE(result.ok());
    return result.value();
}

// Smooth, scrawled, jittery, in steps of whole pixels, there and back, and around in circles.
Polygon path_of_a_hand(Random& random) {
    if (random() % 5 == 0) return random_scrawl(random);
    Polygon path =
        random_path(random, {3, 4}, whole(random, 1, 200), uniform(random, 0.1, 2), uniform(random, 0, 0.5));
    const unsigned kind = random() % 4;
    const double jitter = kind == 1 ? 0.5 : 0, step = kind == 2 ? 0.5 : 0;
    for (Vec2& p : path) {
        p = p + Vec2{uniform(random, -jitter, jitter), uniform(random, -jitter, jitter)};
        if (step > 0) p = {step * std::round(p.x / step), step * std::round(p.y / step)};
    }
    if (kind == 3) path.insert(path.end(), path.rbegin(), path.rend());
    return path;
}

TEST(SweptDisc, is_what_lies_near_the_path) {
    for (int seed = 0; seed < 400; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Plane plane = random_plane(random);
        const double radius = std::exp(uniform(random, -0.7, 3)), tolerance = uniform(random, 0.01, 0.2);
        const Polygon path = path_of_a_hand(random);
        const std::vector<Ring> area = swept(path, radius, tolerance, plane);
        expect_sound({plane, area});
        ASSERT_GT(signed_area(area[0].at), 0);
        for (std::size_t r = 1; r < area.size(); ++r) ASSERT_LT(signed_area(area[r].at), 0);
        Box2 box;
        for (const Vec2 p : path) box.extend(p);
        box = box.grown(1.3 * radius);
        for (const Ring& ring : area) {
            for (const Vec2 p : ring.at) ASSERT_NEAR(distance_to_path(path, p), radius, tolerance) << seed;
        }
        for (int n = 0; n < 400; ++n) {
            const Vec2 p{uniform(random, box.low.x, box.high.x), uniform(random, box.low.y, box.high.y)};
            const double distance = distance_to_path(path, p) - radius;
            if (std::abs(distance) < tolerance + 1e-3) continue;
            ASSERT_EQ(encloses(area, p), distance < 0) << seed;
        }
    }
}

TEST(SweptDisc, of_a_click_is_a_disc) {
    for (const double radius : {0.05, 0.5, 2.0, 5.0, 20.0, 300.0}) {
        for (const double tolerance : {0.001, 0.05, 1.0}) {
            const std::vector<Ring> click = swept(Polygon{{7, 8}}, radius, tolerance);
            ASSERT_EQ(click.size(), 1u);
            EXPECT_NEAR(area_of(click), pi * radius * radius, 1e-3 * pi * radius * radius) << radius;
            for (const Vec2 p : click[0].at) EXPECT_NEAR(length(p - Vec2{7, 8}), radius, tolerance / 4);
        }
    }
    EXPECT_NEAR(area_of(swept(Polygon{{0, 0}, {0, 0}, {0, 0}}, 5)), 78.5, 0.785);
}

// One move, 600 moves of 0.25 mm, and there and back, in any direction.
TEST(SweptDisc, along_a_line_is_a_stadium) {
    const double expected = 25 * pi + 2 * 5 * 150;
    for (int seed = 0; seed < 100; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Plane plane = random_plane(random);
        const double angle = seed < 9 ? seed * pi / 4 : uniform(random, 0, 2 * pi);
        const Vec2 start{uniform(random, -90, 90), uniform(random, -90, 90)},
            along{std::cos(angle), std::sin(angle)};
        Polygon moves;
        for (int n = 0; n <= 600; ++n) moves.push_back(start + 0.25 * n * along);
        Polygon back = moves;
        back.insert(back.end(), moves.rbegin(), moves.rend());
        std::vector<double> areas;
        for (const Polygon& path : {Polygon{moves.front(), moves.back()}, moves, back}) {
            const std::vector<Ring> area = swept(path, 5, 0.05, plane);
            ASSERT_EQ(area.size(), 1u) << seed;
            areas.push_back(area_of(area));
            EXPECT_NEAR(areas.back(), expected, 0.002 * expected) << seed;
        }
        EXPECT_NEAR(areas[1], areas[0], 5e-4 * expected);
        EXPECT_NEAR(areas[2], areas[0], 5e-4 * expected);
    }
}

TEST(SweptDisc, a_bend_adds_what_geometry_says) {
    for (int seed = 0; seed < 200; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const double turn = uniform(random, -2.2, 2.2), from = uniform(random, 0, 6),
                     radius = uniform(random, 1, 8);
        const Vec2 bend = 40 * Vec2{std::cos(from), std::sin(from)};
        const Polygon path{{0, 0}, bend, bend + 40 * Vec2{std::cos(from + turn), std::sin(from + turn)}};
        const double t = std::abs(turn);
        const double expected =
            pi * radius * radius + 2 * radius * 80 + radius * radius * (t / 2 - std::tan(t / 2));
        EXPECT_NEAR(area_of(swept(path, radius)), expected, 0.002 * expected) << turn;
    }
}

TEST(SweptDisc, around_a_loop_leaves_its_hole) {
    Polygon loop = circle({0, 0}, 20, 100);
    loop.push_back(loop[0]);
    const std::vector<Ring> area = swept(loop, 5);
    ASSERT_EQ(area.size(), 2u);
    EXPECT_NEAR(area_of(area), pi * (625 - 225), 0.002 * 400 * pi);
    loop.pop_back();
    EXPECT_EQ(swept(loop, 5).size(), 2u);  // the discs at both ends overlap
    EXPECT_EQ(swept(loop, 25).size(), 1u);
}

TEST(SweptDisc, refuses_bad_options) {
    const Polygon path{{0, 0}, {1, 1}};
    for (const double bad : {0.0, -1.0, 1001.0, double{NAN}}) {
        EXPECT_EQ(swept_disc(path, {}, {bad, 0.05}).error().code, "E-LIV-008");
        EXPECT_EQ(swept_disc(path, {}, {5, bad}).error().code, "E-LIV-008");
        const Polygon nowhere{{0, 0}, {1e9, bad * 1e9}};
        EXPECT_EQ(swept_disc(nowhere, {}, {}).error().code, "E-LIV-001");
    }
}

// 600 points on a ring of 500 vertices: 5 ms are the aim, and a slow machine under test may take four times as long.
TEST(SweptDisc, is_fast_enough_to_follow_the_hand) {
    Polygon path;
    for (int n = 0; n < 600; ++n) path.push_back(40 * Vec2{std::cos(n * 0.25 / 40), std::sin(n * 0.25 / 40)});
    const StructureRings ring = rings_of({circle({0, 0}, 40, 500)}, {});
    double least = 1e9;
    for (int repeat = 0; repeat < 5; ++repeat) {
        const auto start = std::chrono::steady_clock::now();
        const CombinedArea united = combine_area(ring, swept(path, 5), AreaRule::unite).value();
        const auto end = std::chrono::steady_clock::now();
        least = std::min(least, std::chrono::duration<double, std::milli>(end - start).count());
        EXPECT_EQ(united.effect, AreaEffect::extended);
    }
#ifdef NDEBUG
    EXPECT_LT(least, 20);
#endif
}

}  // namespace
}  // namespace anatomesh::swept_disc_test
