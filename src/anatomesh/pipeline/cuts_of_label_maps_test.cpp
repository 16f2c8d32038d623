// Cuts of models by their slices' planes, of label maps whose structures touch in corners of voxels.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "anatomesh/contour/trace.h"
#include "anatomesh/pipeline/build_model.h"

namespace anatomesh {
namespace {

constexpr std::uint32_t columns = 16, slices = 5, rim = 2;

// Every voxel, away from the rim, has the label of the largest of some sums of random waves: walls, thin
// places and corners in every direction.
LabelMap random_labels(std::uint32_t seed, std::uint16_t labels) {
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

TEST(CutsOfLabelMaps, are_what_is_drawn) {
    std::size_t cuts = 0, off = 0;
    double wrong = 0, drawn = 0;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        RunContext context;
        const auto traced = trace_contours(random_labels(seed, static_cast<std::uint16_t>(1 + seed % 3)),
                                           nullptr, 0, {}, context);
        ASSERT_TRUE(traced.ok()) << to_line(traced.error());
        const auto model = build_model(traced.value().kept, {}, context);
        ASSERT_TRUE(model.ok()) << to_line(model.error());
        for (const SliceCutReport& cut : model.value().report.cuts) {
            ++cuts;
            off += cut.difference_mm2 > 1e-3 * cut.drawn_mm2;
            wrong += cut.difference_mm2;
            drawn += cut.drawn_mm2;
        }
    }
    // Where pieces of a structure that touch in a point are given away: 3 of 51, and a 2700th.
    EXPECT_LE(25 * off, cuts);
    EXPECT_LT(3000 * wrong, drawn);
}

}  // namespace
}  // namespace anatomesh
