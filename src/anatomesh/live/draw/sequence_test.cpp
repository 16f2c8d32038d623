#include <gtest/gtest.h>

#include <cfenv>

#include "anatomesh/live/draw/area/draw_fixtures.h"
#include "anatomesh/live/draw/brush.h"
#include "anatomesh/live/draw/copy_rings.h"
#include "anatomesh/live/draw/nudge.h"
#include "anatomesh/live/draw/spline.h"
#include "anatomesh/live/draw/stroke.h"

namespace anatomesh::sequence_test {
namespace {

using namespace draw_fixtures;

// What a hand does next: any tool, in any mode, anywhere near the structure.
Result<DrawResult> next_drawing(Random& random, const StructureRings& before) {
    const Vec2 start{uniform(random, -20, 80), uniform(random, -20, 80)};
    const std::vector<Vec2> picture{{-40, -40}, {100, -40}, {100, 100}, {-40, 100}};
    const auto mode = static_cast<DrawMode>(random() % 5);
    const DrawMode area_mode = mode == DrawMode::reshape ? DrawMode::automatic : mode;
    const Polygon path = random_path(random, start, whole(random, 0, 120), uniform(random, 0.2, 1.5), 0.1);
    switch (random() % 5) {
        case 0: {
            BrushOptions options;
            options.disc.radius_mm = uniform(random, 0.5, 9);
            options.mode = random() % 2 ? DrawMode::extend : DrawMode::cut;
            options.clip = picture;
            return draw_brush(before, path, options);
        }
        case 1: {
            NudgeOptions options;
            options.disc.radius_mm = uniform(random, 1, 12);
            options.clip = picture;
            return nudge_outline(before, path, options);
        }
        case 2: {
            SplineOptions options;
            options.mode = area_mode;
            return draw_spline(before, circle(start, uniform(random, 3, 20), whole(random, 3, 9)), options);
        }
        case 3: {
            // From one place on an outline to another one.
            if (before.rings.empty()) return nothing_drawn(before, NothingDrawn::no_outline);
            const Ring& ring = before.rings[random() % before.rings.size()];
            const std::size_t n = ring.size(), i = random() % n, j = (i + n / 4) % n;
            StrokeOptions options;
            options.mode = DrawMode::reshape;
            const Vec2 middle =
                0.5 * (ring.at[i] + ring.at[j]) + Vec2{uniform(random, -9, 9), uniform(random, -9, 9)};
            return draw_stroke(before, Polygon{ring.at[i], middle, ring.at[j]}, options);
        }
        default: {
            StrokeOptions options;
            options.mode = mode;
            options.clip = picture;
            return draw_stroke(before, path, options);
        }
    }
}

StructureRings drawn(int seed, bool check) {
    Random random(static_cast<unsigned>(seed));
    StructureRings rings = random_rings(random, random_plane(random));
    for (int step = 0; step < 40; ++step) {
        const Result<DrawResult> next = next_drawing(random, rings);
        EXPECT_TRUE(next.ok()) << seed << " " << step;
        if (!next.ok()) break;
        if (check) expect_sound(next.value().rings);
        EXPECT_TRUE(next.value().effect != AreaEffect::nothing || same_bytes(next.value().rings, rings));
        rings = next.value().rings;
    }
    return rings;
}

TEST(Sequence, of_any_tools_leaves_sound_rings) {
    for (int seed = 0; seed < 60; ++seed) {
        drawn(seed, true);
        if (HasFailure()) FAIL() << seed;
    }
}

TEST(Sequence, gives_the_same_bytes_again) {
    for (int seed = 0; seed < 20; ++seed) EXPECT_TRUE(same_bytes(drawn(seed, false), drawn(seed, false)));
}

TEST(Sequence, does_not_depend_on_the_rounding_of_the_caller) {
    Random random(3);
    const StructureRings before = random_rings(random, make_plane({1, 2, 3}, {0.1, 0.4, 1}));
    const Polygon path = random_path(random, {10, 10}, 150, 0.7, 0.03);
    const Polygon controls = circle({40, 10}, 25, 9);
    const Plane turned = make_plane({4, 5, 6}, {0.3, 0.4, 1});
    const auto all_tools = [&] {
        return std::vector{
            draw_stroke(before, path, {}).value().rings, draw_brush(before, path, {}).value().rings,
            nudge_outline(before, path, {}).value().rings, draw_spline(before, controls, {}).value().rings,
            copy_rings(before, turned).value()};
    };
    const std::vector<StructureRings> expected = all_tools();
    for (std::size_t k : {0u, 1u, 3u, 4u}) EXPECT_FALSE(same_bytes(expected[k], before)) << k;
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
        std::fesetround(mode);
        const std::vector<StructureRings> results = all_tools();
        const int kept = std::fegetround();
        std::fesetround(FE_TONEAREST);
        EXPECT_EQ(kept, mode);
        for (std::size_t k = 0; k < results.size(); ++k)
            EXPECT_TRUE(same_bytes(results[k], expected[k])) << mode << " " << k;
    }
}

}  // namespace
}  // namespace anatomesh::sequence_test
