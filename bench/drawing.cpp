// Hot pieces, continued: the tools of a hand (live/draw/), on a ring of 500 vertices on a tilted plane.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

#include "anatomesh/live/draw/brush.h"
#include "anatomesh/live/draw/nudge.h"
#include "anatomesh/live/draw/spline.h"
#include "anatomesh/live/draw/stroke.h"

namespace {

using namespace anatomesh;

std::vector<Vec2> circle(Vec2 centre, double radius, int points) {
    std::vector<Vec2> polygon;
    for (int n = 0; n < points; ++n) {
        const double angle = 2 * std::numbers::pi * n / points;
        polygon.push_back(centre + radius * Vec2{std::cos(angle), std::sin(angle)});
    }
    return polygon;
}

StructureRings ring_of_500() {
    const Plane plane = make_plane({10, 20, 30}, {0.2, 0.3, 1});
    return {plane, {ring_of(circle({0, 0}, 40, 500), plane)}};
}

enum Hand : int { smooth, whole_pixels, jittery, hatching };

// A path of 600 points, 0.25 mm apart: an arc; the same in whole pixels of 0.25 mm, or with a jitter of one pixel; or to and
// fro over 60 mm.
std::vector<Vec2> path_of_600(int hand) {
    std::mt19937 random(1);
    const auto jitter = [&] { return 0.5 * (random() / 4294967296.0) - 0.25; };
    std::vector<Vec2> path;
    for (int n = 0; n < 600; ++n) {
        Vec2 p{40 * std::cos(n * 0.25 / 40), 40 * std::sin(n * 0.25 / 40)};
        if (hand == whole_pixels) p = {0.25 * std::round(4 * p.x), 0.25 * std::round(4 * p.y)};
        if (hand == jittery) p = p + Vec2{jitter(), jitter()};
        if (hand == hatching) p = {30 * std::sin(n * 0.3), 0.05 * n};
        path.push_back(p);
    }
    return path;
}

void draw_by_brush(benchmark::State& state) {
    const StructureRings before = ring_of_500();
    const std::vector<Vec2> path = path_of_600(static_cast<int>(state.range(0)));
    BrushOptions options;
    options.disc.radius_mm = static_cast<double>(state.range(1));
    for (auto _ : state) benchmark::DoNotOptimize(draw_brush(before, path, options));
}
BENCHMARK(draw_by_brush)
    ->Args({smooth, 5})
    ->Args({smooth, 20})
    ->Args({whole_pixels, 5})
    ->Args({whole_pixels, 20})
    ->Args({jittery, 5})
    ->Args({hatching, 5})
    ->Unit(benchmark::kMillisecond);

void draw_by_stroke(benchmark::State& state) {
    const StructureRings before = ring_of_500();
    const std::vector<Vec2> stroke = circle({40, 0}, 24, 600);
    for (auto _ : state) benchmark::DoNotOptimize(draw_stroke(before, stroke, {}));
}
BENCHMARK(draw_by_stroke)->Unit(benchmark::kMillisecond);

void reshape_by_stroke(benchmark::State& state) {
    const StructureRings before = ring_of_500();
    std::vector<Vec2> stroke;
    for (int n = 0; n <= 200; ++n) {
        const double share = n / 200.0, radius = 40 + 10 * std::sin(std::numbers::pi * share);
        stroke.push_back(radius * Vec2{std::cos(share), std::sin(share)});
    }
    StrokeOptions options;
    options.mode = DrawMode::reshape;
    for (auto _ : state) benchmark::DoNotOptimize(draw_stroke(before, stroke, options));
}
BENCHMARK(reshape_by_stroke)->Unit(benchmark::kMillisecond);

void draw_by_nudge(benchmark::State& state) {
    const StructureRings before = ring_of_500();
    std::vector<Vec2> path;
    for (int n = 0; n <= 60; ++n) path.push_back({55 - 0.25 * n, 0});
    for (auto _ : state) benchmark::DoNotOptimize(nudge_outline(before, path, {}));
}
BENCHMARK(draw_by_nudge)->Unit(benchmark::kMillisecond);

void draw_by_spline(benchmark::State& state) {
    const StructureRings before = ring_of_500();
    const std::vector<Vec2> controls = circle({40, 0}, 24, 20);
    for (auto _ : state) benchmark::DoNotOptimize(draw_spline(before, controls, {}));
}
BENCHMARK(draw_by_spline)->Unit(benchmark::kMillisecond);

}  // namespace
