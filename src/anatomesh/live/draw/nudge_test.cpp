#include "anatomesh/live/draw/nudge.h"

#include <gtest/gtest.h>

#include "anatomesh/live/draw/area/draw_fixtures.h"

namespace anatomesh::nudge_test {
namespace {

using namespace draw_fixtures;

constexpr double pi = std::numbers::pi;
constexpr double pixel = 1;

DrawResult nudged(const StructureRings& before, std::span<const Vec2> path, double radius) {
    NudgeOptions options;
    options.disc.radius_mm = radius;
    options.pixel_mm = pixel;
    Result<DrawResult> result = nudge_outline(before, path, options);
    EXPECT_TRUE(result.ok());
    expect_sound(result.value().rings);
    return result.value();
}

double longest_edge(const StructureRings& drawn) {
    double longest = 0;
    for (const Ring& ring : drawn.rings) {
        for (std::size_t i = 0; i < ring.size(); ++i)
            longest = std::max(longest, length(ring.at[(i + 1) % ring.size()] - ring.at[i]));
    }
    return longest;
}

// Spacing, and bytes of what the disc did not reach.
void expect_laws(const StructureRings& before, const DrawResult& result, std::span<const Vec2> path,
                 double radius) {
    std::vector<Vec3> old;
    for (const Ring& ring : before.rings) old.insert(old.end(), ring.points.begin(), ring.points.end());
    std::sort(old.begin(), old.end(), LexicographicLess{});
    const auto is_old = [&](Vec3 p) {
        return std::binary_search(old.begin(), old.end(), p, LexicographicLess{});
    };
    std::vector<Vec3> kept;
    for (const Ring& ring : result.rings.rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const std::size_t next = (i + 1) % ring.size();
            const double spacing = length(ring.at[next] - ring.at[i]);
            EXPECT_LE(spacing, 2 * longest_edge(before));
            EXPECT_TRUE(spacing >= 0.15 * pixel || (is_old(ring.points[i]) && is_old(ring.points[next])))
                << spacing;
            kept.push_back(ring.points[i]);
        }
    }
    std::sort(kept.begin(), kept.end(), LexicographicLess{});
    if (result.dropped_pieces > 0) return;  // their vertices went with them
    for (const Ring& ring : before.rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            if (distance_to_path(path, ring.at[i]) < radius + 0.06) continue;
            EXPECT_TRUE(std::binary_search(kept.begin(), kept.end(), ring.points[i], LexicographicLess{}));
        }
    }
}

Polygon radial(double angle, double from, double to) {
    Polygon path;
    for (int n = 0; n <= 60; ++n) {
        const double r = from + (to - from) * n / 60;
        path.push_back(r * Vec2{std::cos(angle), std::sin(angle)});
    }
    return path;
}

TEST(Nudge, in_and_out_again_ten_times_is_always_one_simple_ring) {
    for (int seed = 0; seed < 20; ++seed) {
        Random random(static_cast<unsigned>(seed));
        StructureRings ring = rings_of({circle({0, 0}, 30, 200)}, random_plane(random));
        for (int n = 0; n < 10; ++n) {
            const double angle = uniform(random, 0, 2 * pi);
            for (const Polygon& path : {radial(angle, 40, 25), radial(angle, 5, 20)}) {
                const StructureRings before = ring;
                const DrawResult result = nudged(before, path, 10);
                ASSERT_EQ(result.rings.rings.size(), 1u) << seed << " " << n;
                expect_laws(before, result, path, 10);
                ring = result.rings;
                // The hull of the first circle and all sweeps is the disc of radius 30.
                for (const Vec2 p : ring.rings[0].at) ASSERT_LT(length(p), 30.06);
            }
        }
    }
}

TEST(Nudge, pushes_out_from_inside_and_in_from_outside) {
    const StructureRings before = rings_of({circle({0, 0}, 30, 200)}, {});
    const Polygon out = radial(1, 10, 30), in = radial(1, 45, 30);
    const DrawResult pushed_out = nudged(before, out, 10), pushed_in = nudged(before, in, 10);
    EXPECT_EQ(pushed_out.effect, AreaEffect::extended);
    EXPECT_EQ(pushed_in.effect, AreaEffect::cut);
    EXPECT_TRUE(encloses(pushed_out.rings.rings, 39 * Vec2{std::cos(1), std::sin(1)}));
    EXPECT_FALSE(encloses(pushed_in.rings.rings, 21 * Vec2{std::cos(1), std::sin(1)}));
    // Nothing is pushed where the disc meets no outline.
    for (const Polygon& path : {radial(2, 0, 15), radial(2, 50, 60)}) {
        const DrawResult nothing = nudged(before, path, 10);
        EXPECT_EQ(nothing.reason, NothingDrawn::nothing_there);
        EXPECT_TRUE(same_bytes(nothing.rings, before));
    }
    EXPECT_EQ(nudged({}, in, 10).reason, NothingDrawn::nothing_there);
}

TEST(Nudge, keeps_its_laws_for_random_hands) {
    int changed = 0;
    for (int seed = 0; seed < 200; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const StructureRings before = random_rings(random, random_plane(random));
        const double radius = uniform(random, 0.5, 12);
        const Polygon path = random_path(random, {uniform(random, -30, 90), uniform(random, -30, 90)},
                                         whole(random, 1, 60), 0.5, 0.05);
        const DrawResult result = nudged(before, path, radius);
        changed += result.effect != AreaEffect::nothing;
        const bool begins_inside = encloses(before.rings, path[0]);
        EXPECT_FALSE(begins_inside && result.effect == AreaEffect::cut);
        expect_laws(before, result, path, radius);
    }
    EXPECT_GT(changed, 80);
}

TEST(Nudge, makes_no_new_ring_of_small_pieces) {
    // A thumb pushes a finger's tip against the next finger: the gap between them goes, and nothing is cut off.
    const StructureRings before =
        rings_of({{{0, 0}, {60, 0}, {60, 40}, {40, 40}, {40, 20}, {20, 20}, {20, 40}, {0, 40}}}, {});
    const DrawResult bridged = nudged(before, Polygon{{15, 35}, {38, 35}}, 4);
    EXPECT_EQ(bridged.rings.rings.size(), 2u);  // the gap of 220 mm2 is larger than the disc
    const DrawResult filled = nudged(before, Polygon{{10, 25}, {50, 25}}, 4.5);
    EXPECT_EQ(filled.rings.rings.size(), 1u);  // the gap of about 10 mm2 is smaller
}

}  // namespace
}  // namespace anatomesh::nudge_test
