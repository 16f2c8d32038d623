// Cuts of models by their slices' planes, of label maps whose structures touch in corners of voxels.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "anatomesh/contour/trace/trace.h"
#include "anatomesh/pipeline/build_model.h"

namespace anatomesh::cuts_of_label_maps_test {
namespace {

constexpr std::uint32_t rim = 2;

// Every voxel, away from the rim, has the label of the largest of some sums of random waves: walls, thin
// places and corners in every direction.
LabelMap random_labels(std::uint32_t seed, std::uint16_t labels, std::uint32_t columns,
                       std::uint32_t slices) {
    LabelMap map;
    map.geometry.size = {columns, columns, slices};
    map.geometry.step = {Vec3{1.5, 0, 0}, Vec3{0, 1.5, 0}, Vec3{0, 0, 3}};
    map.voxels.assign(map.geometry.voxel_count(), 0);
    for (std::uint16_t s = 1; s <= labels; ++s) map.structures.push_back({s, "s" + std::to_string(s), {}});
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> frequency(-1.6, 1.6), phase(0, 6.28);
    constexpr int waves = 8;
    std::vector<std::array<double, 4>> wave(std::size_t{waves} * (labels + 1u));
    for (auto& w : wave) w = {frequency(random), frequency(random), frequency(random), phase(random)};
    for (std::uint32_t k = 1; k + 1 < slices; ++k) {
        for (std::uint32_t j = rim; j + rim < columns; ++j) {
            for (std::uint32_t i = rim; i + rim < columns; ++i) {
                double most = -1e9;
                for (std::uint16_t s = 0; s <= labels; ++s) {
                    double sum = 0;
                    for (int n = 0; n < waves; ++n) {
                        const auto& w = wave[std::size_t{s} * waves + static_cast<std::size_t>(n)];
                        sum += std::cos(w[0] * i + w[1] * j + w[2] * k + w[3]);
                    }
                    if (sum <= most) continue;
                    most = sum;
                    map.voxels[map.geometry.index(i, j, k)] = s;
                }
            }
        }
    }
    return map;
}

struct Cuts {
    std::size_t count = 0, off = 0;  // by more than 0.1 %
    double wrong = 0, drawn = 0;     // mm^2
};

void add_cuts(const LabelMap& map, double size_mm, Cuts& cuts) {
    RunContext context;
    const auto traced = trace_contours(map, nullptr, 0, {}, context);
    ASSERT_TRUE(traced.ok()) << to_line(traced.error());
    ModelOptions options;
    options.size_mm = size_mm;
    const auto model = build_model(traced.value().kept, options, context);
    ASSERT_TRUE(model.ok()) << to_line(model.error());
    for (const SliceSectionReport& cut : model.value().report.contours.sections) {
        ++cuts.count;
        cuts.off += cut.difference_mm2 > 1e-3 * cut.drawn_mm2;
        cuts.wrong += cut.difference_mm2;
        cuts.drawn += cut.drawn_mm2;
    }
}

TEST(CutsOfLabelMaps, are_what_is_drawn) {
    Cuts cuts;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE(seed);
        add_cuts(random_labels(seed, static_cast<std::uint16_t>(1 + seed % 3), 16, 5), 0, cuts);
    }
    // Where pieces of a structure that touch in a point are relabelled: 3 of 51, and a 2700th.
    EXPECT_LE(25 * cuts.off, cuts.count);
    EXPECT_LT(3000 * cuts.wrong, cuts.drawn);
}

TEST(CutsOfLabelMaps, of_many_structures_are_what_is_drawn) {
    Cuts cuts;
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE(seed);
        add_cuts(random_labels(seed, static_cast<std::uint16_t>(4 + seed % 4), 24, 8), 3, cuts);
    }
    // 3 of 108, and a 4789th; before surfaces that pass through planes elsewhere were mended one of 8, and a
    // 2500th.
    EXPECT_LE(30 * cuts.off, cuts.count);
    EXPECT_LT(4000 * cuts.wrong, cuts.drawn);
}

// A wall along a surface of random waves, thin against the voxels' distance.
LabelMap random_wall(std::uint32_t seed) {
    constexpr std::uint32_t width = 40, height = 8;
    LabelMap map;
    map.geometry.size = {width, width, height};
    map.geometry.step = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 6}};
    map.voxels.assign(map.geometry.voxel_count(), 0);
    map.structures = {{1, "wall", {}}};
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> frequency(-0.3, 0.3), phase(0, 6.28);
    std::array<std::array<double, 4>, 8> waves;
    for (auto& w : waves) w = {frequency(random), frequency(random), 2 * frequency(random), phase(random)};
    for (std::uint32_t k = 1; k + 1 < height; ++k) {
        for (std::uint32_t j = rim; j + rim < width; ++j) {
            for (std::uint32_t i = rim; i + rim < width; ++i) {
                double sum = 0;
                for (const auto& w : waves) sum += std::cos(w[0] * i + w[1] * j + w[2] * k + w[3]);
                map.voxels[map.geometry.index(i, j, k)] = std::abs(sum) < 0.6;
            }
        }
    }
    return map;
}

// Where edges are longer than the slices are apart, a cell that is relabelled for a cut's sake reaches far.
TEST(CutsOfLabelMaps, of_coarse_models_of_thin_walls_are_not_had_by_spikes) {
    for (std::uint32_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(seed);
        RunContext context;
        const auto traced = trace_contours(random_wall(seed), nullptr, 0, {}, context);
        ASSERT_TRUE(traced.ok()) << to_line(traced.error());
        ModelOptions options;
        options.size_mm = 10;
        const auto model = build_model(traced.value().kept, options, context);
        ASSERT_TRUE(model.ok()) << to_line(model.error());
        EXPECT_LT(model.value().report.field.distance.max_mm, 0.5 * options.size_mm);
    }
}

}  // namespace
}  // namespace anatomesh::cuts_of_label_maps_test
