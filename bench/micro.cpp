// The hot pieces of the method alone. Inputs are made here: a wavy ball of one structure, and random points.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "anatomesh/contour/trace/trace.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/field/slice/bit_volume.h"
#include "anatomesh/field/slice/distance_map.h"
#include "anatomesh/field/slice/distance_raster.h"
#include "anatomesh/live/livewire/livewire.h"
#include "delaunay_peer.h"

namespace {

using namespace anatomesh;

// A ball with 12 ridges in the middle of a volume of n x n x slices voxels, the slices as far apart as makes
// it a cube.
LabelMap wavy_ball(std::uint32_t n, std::uint32_t slices) {
    LabelMap labels;
    const double thickness = static_cast<double>(n) / slices;
    labels.geometry.size = {n, n, slices};
    labels.geometry.step[2] = {0, 0, thickness};
    labels.voxels.resize(labels.geometry.voxel_count());
    labels.structures.push_back({1, "ball", {200, 200, 200}});
    const double middle = 0.5 * n;
    for (std::uint32_t k = 0; k < slices; ++k) {
        for (std::uint32_t j = 0; j < n; ++j) {
            for (std::uint32_t i = 0; i < n; ++i) {
                const double x = i - middle, y = j - middle, z = k * thickness - middle;
                const double radius = middle * (0.8 + 0.1 * std::cos(12 * std::atan2(y, x)));
                labels.voxels[labels.geometry.index(i, j, k)] =
                    x * x + y * y + z * z < radius * radius ? 1 : 0;
            }
        }
    }
    return labels;
}

ContourSet traced_ball(std::uint32_t n, std::uint32_t slices) {
    RunContext context;
    auto traced = trace_contours(wavy_ball(n, slices), nullptr, 0, {}, context);
    return std::move(traced).value().kept;
}

std::vector<Vec3> random_points(std::size_t count, const Box3& box) {
    std::mt19937_64 random(1);
    const auto between = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    std::vector<Vec3> points(count);
    for (Vec3& p : points) {
        p.x = between(box.low.x, box.high.x);
        p.y = between(box.low.y, box.high.y);
        p.z = between(box.low.z, box.high.z);
    }
    return points;
}

void trace_label_map(benchmark::State& state) {
    const LabelMap labels = wavy_ball(512, 16);
    for (auto _ : state) {
        RunContext context;
        benchmark::DoNotOptimize(trace_contours(labels, nullptr, 0, {}, context));
    }
    state.counters["voxels/s"] = benchmark::Counter(static_cast<double>(labels.voxels.size()),
                                                    benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(trace_label_map)->Unit(benchmark::kMillisecond);

void make_field(benchmark::State& state) {
    const ContourSet contours = traced_ball(256, 64);
    for (auto _ : state) {
        RunContext context;
        benchmark::DoNotOptimize(make_structure_field(contours, {}, context));
    }
    state.counters["contour points/s"] = benchmark::Counter(static_cast<double>(contours.points.size()),
                                                            benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(make_field)->Unit(benchmark::kMillisecond);

void query_field(benchmark::State& state) {
    const ContourSet contours = traced_ball(256, 64);
    RunContext context;
    const auto field = make_structure_field(contours, {}, context).value();
    const std::vector<Vec3> points = random_points(1 << 16, field->box());
    std::size_t n = 0;
    for (auto _ : state) benchmark::DoNotOptimize(field->value(0, points[n++ & 0xFFFF]));
    state.counters["queries/s"] = benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(query_field);

// The edges of all contours of a slice, in its plane.
std::vector<Edge2> edges_of(const ContourSet& contours, const Slice& slice) {
    std::vector<Edge2> edges;
    for (const Contour& contour : contours.contours_of(slice)) {
        const auto points = contours.points_of(contour);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3 a = points[i], b = points[(i + 1) % points.size()];
            edges.push_back({slice.plane.to_plane(a), slice.plane.to_plane(b)});
        }
    }
    return edges;
}

// Construction, then the value at each of 512 x 512 points, clamped at 16 pixels as the field clamps it.
void distance_map_512(benchmark::State& state) {
    const ContourSet contours = traced_ball(512, 16);
    const std::vector<Edge2> edges = edges_of(contours, contours.slices[contours.slices.size() / 2]);
    for (auto _ : state) {
        const DistanceMap map(edges, 16);
        const Box2 box = map.region_box();
        const Vec2 step = (1.0 / 511) * (box.high - box.low);
        double sum = 0;
        for (int j = 0; j < 512; ++j) {
            for (int i = 0; i < 512; ++i) sum += map.value(box.low + Vec2{i * step.x, j * step.y});
        }
        benchmark::DoNotOptimize(sum);
    }
    state.counters["edges"] = static_cast<double>(edges.size());
}
BENCHMARK(distance_map_512)->Unit(benchmark::kMillisecond);

// One slice's bit volume and distance map as the 2006 method has them: n x n pixels, no clamp.
void rasters_of_slices(benchmark::State& state) {
    const auto n = static_cast<std::uint32_t>(state.range(0)),
               slices = static_cast<std::uint32_t>(state.range(1));
    const ContourSet contours = traced_ball(n, 64);
    const PixelGrid grid{{0, 0}, {1, 1}, n, n};
    double edge_count = 0;
    std::vector<std::vector<Edge2>> edges;
    for (std::uint32_t k = 0; k < slices; ++k) {
        const std::size_t middle = contours.slices.size() / 2;
        edges.push_back(edges_of(contours, contours.slices[(middle + k) % contours.slices.size()]));
        edge_count += static_cast<double>(edges.back().size());
    }
    for (auto _ : state) {
        BitVolume bits(grid, slices);
        for (std::uint32_t k = 0; k < slices; ++k) {
            bits.fill(k, edges[k]);
            benchmark::DoNotOptimize(distance_raster(edges[k], grid));
        }
        benchmark::DoNotOptimize(bits.count());
    }
    state.counters["edges/slice"] = edge_count / slices;
}
BENCHMARK(rasters_of_slices)->Args({512, 1})->Args({256, 256})->Unit(benchmark::kMillisecond);

const Box3 cube{{0, 0, 0}, {200, 200, 200}};

void count_points(benchmark::State& state, const std::vector<Vec3>& points) {
    state.counters["points/s"] =
        benchmark::Counter(static_cast<double>(points.size()), benchmark::Counter::kIsIterationInvariantRate);
}

// Arguments: points, threads.
void delaunay(benchmark::State& state) {
    const std::vector<Vec3> points = random_points(static_cast<std::size_t>(state.range(0)), cube);
    const int threads = static_cast<int>(state.range(1));
    for (auto _ : state) benchmark::DoNotOptimize(Tetrahedralization::create(points, threads));
    count_points(state, points);
}
BENCHMARK(delaunay)
    ->ArgsProduct({{10'000, 100'000, 1'000'000}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

void delaunay_by_cgal(benchmark::State& state) {
    const std::vector<Vec3> points = random_points(static_cast<std::size_t>(state.range(0)), cube);
    for (auto _ : state) benchmark::DoNotOptimize(cells_by_cgal(points));
    count_points(state, points);
}
BENCHMARK(delaunay_by_cgal)
    ->Arg(10'000)
    ->Arg(100'000)
    ->Arg(1'000'000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// A few thousand points into many, and what the stages then read of it.
void delaunay_insertion(benchmark::State& state) {
    const std::vector<Vec3> points = random_points(150'000, cube), more = random_points(153'000, cube);
    for (auto _ : state) {
        state.PauseTiming();
        Tetrahedralization mesh = std::move(Tetrahedralization::create(points)).value();
        mesh.snapshot();
        state.ResumeTiming();
        mesh.insert(std::span(more).subspan(150'000));
        benchmark::DoNotOptimize(mesh.snapshot().cells.data());
    }
}
BENCHMARK(delaunay_insertion)->Unit(benchmark::kMillisecond);

// A slice of n x n pixels with twelve bright discs, and noise of a fifth of their contrast.
GreyPicture discs_in_noise(std::uint32_t side) {
    const double n = side;
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0, 20);
    GreyPicture slice;
    slice.grid = {{side, side}, {0.7, 0.7}};
    slice.pixels.resize(slice.grid.count());
    for (std::uint32_t v = 0; v < slice.pixels.size(); ++v) {
        const Pixel p = slice.grid.pixel(v);
        double grey = noise(random);
        for (int disc = 0; disc < 12; ++disc) {
            const Vec2 middle{n * (0.1 + disc * 7 % 12 / 15.0), n * (0.1 + disc * 5 % 12 / 15.0)};
            if (length(Vec2{double(p.i), double(p.j)} - middle) < 0.03 * n * (1 + disc % 4)) grey += 100;
        }
        slice.pixels[v] = static_cast<float>(grey);
    }
    return slice;
}

// Argument of all: the pixels of a side.
void livewire_features(benchmark::State& state) {
    const GreyPicture slice = discs_in_noise(static_cast<std::uint32_t>(state.range(0)));
    RunContext context;
    for (auto _ : state) benchmark::DoNotOptimize(find_edge_features(slice, {}, context));
}
BENCHMARK(livewire_features)->Arg(512)->Arg(1024)->Unit(benchmark::kMillisecond);

LivewireCosts costs_of_discs(std::uint32_t n) {
    RunContext context;
    const EdgeFeatures features = find_edge_features(discs_in_noise(n), {}, context).value();
    return make_livewire_costs(features, nullptr, {}, context).value();
}

void livewire_costs(benchmark::State& state) {
    RunContext context;
    const GreyPicture slice = discs_in_noise(static_cast<std::uint32_t>(state.range(0)));
    const EdgeFeatures features = find_edge_features(slice, {}, context).value();
    for (auto _ : state) benchmark::DoNotOptimize(make_livewire_costs(features, nullptr, {}, context));
}
BENCHMARK(livewire_costs)->Arg(512)->Arg(1024)->Unit(benchmark::kMillisecond);

// A click, and a pointer up to 100 pixels away along each axis: what a user waits for.
void livewire_line(benchmark::State& state) {
    const LivewireCosts costs = costs_of_discs(static_cast<std::uint32_t>(state.range(0)));
    Livewire wire(costs);
    std::mt19937 random(2);
    const auto below = [&](std::uint32_t bound) { return 0.7 * (random() % bound); };
    for (auto _ : state) {
        const Vec2 anchor{below(costs.grid.size[0]), below(costs.grid.size[1])};
        const Vec2 pointer = anchor + Vec2{below(201) - 70, below(201) - 70};
        benchmark::DoNotOptimize(wire.set_anchor(anchor));
        benchmark::DoNotOptimize(wire.line_to(pointer));
    }
}
BENCHMARK(livewire_line)->Arg(512)->Arg(1024)->Unit(benchmark::kMillisecond);

// All paths from the middle: the most that one anchor costs.
void livewire_all_paths(benchmark::State& state) {
    const LivewireCosts costs = costs_of_discs(static_cast<std::uint32_t>(state.range(0)));
    Livewire wire(costs);
    const Vec2 middle = 0.5 * costs.grid.position({costs.grid.size[0], costs.grid.size[1]});
    for (auto _ : state) {
        benchmark::DoNotOptimize(wire.set_anchor(middle));
        benchmark::DoNotOptimize(wire.settle_ahead(static_cast<std::uint32_t>(costs.grid.count())));
    }
}
BENCHMARK(livewire_all_paths)->Arg(512)->Arg(1024)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
