#include "anatomesh/contour/trace/sparse_structures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "anatomesh/contour/trace/trace.h"

namespace anatomesh::sparse_structures_test {
namespace {

constexpr std::uint32_t size = 40;

LabelMap map_of(const std::function<int(std::array<std::uint32_t, 3>)>& label, int structures = 1) {
    LabelMap map;
    map.geometry.size = {size, size, size};
    map.geometry.step = {Vec3{0.5, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 2}};
    map.voxels.assign(map.geometry.voxel_count(), 0);
    for (int s = 1; s <= structures; ++s) map.structures.push_back({s, "s" + std::to_string(s), {}});
    for (std::uint32_t k = 0; k < size; ++k)
        for (std::uint32_t j = 0; j < size; ++j)
            for (std::uint32_t i = 0; i < size; ++i)
                map.voxels[map.geometry.index(i, j, k)] = static_cast<std::uint16_t>(label({i, j, k}));
    return map;
}

bool in_ball(const std::array<std::uint32_t, 3>& at, double radius) {
    const auto off = [&](std::size_t a) { return static_cast<double>(at[a]) - 19.6; };
    return off(0) * off(0) + off(1) * off(1) + off(2) * off(2) < radius * radius;
}

// Balls of any radius, painted on every n-th slice along any axis from any slice on.
TEST(SparseStructures, ABallOnEveryNthSliceIsFoundAndTheWholeOneIsNot) {
    std::mt19937 random(1);
    std::size_t found = 0;
    for (int round = 0; round < 60; ++round) {
        const double radius = 8 + static_cast<double>(random() % 100) / 10;
        const std::uint32_t axis = random() % 3, step = 2 + random() % 4, first = random() % step;
        const LabelMap map = map_of([&](auto at) { return in_ball(at, radius) && at[axis] % step == first; });
        const std::vector<SparseStructure> sparse = find_sparse_structures(map);
        const double slices = 2 * radius / step;
        if (slices < 4.5) continue;  // hardly three slices that overlap
        ASSERT_EQ(sparse.size(), 1u) << radius << ' ' << axis << ' ' << step;
        EXPECT_EQ(sparse[0].axis, axis);
        EXPECT_EQ(sparse[0].step, step);
        const double ball_mm3 = 4 * std::numbers::pi / 3 * radius * radius * radius;  // a voxel is 1 mm3
        EXPECT_NEAR(sparse[0].joined_mm3, ball_mm3, 0.12 * ball_mm3) << radius << ' ' << step;
        EXPECT_NEAR(sparse[0].painted_mm3, ball_mm3 / step, 0.12 * ball_mm3 / step + 60);
        EXPECT_TRUE(find_sparse_structures(map_of([&](auto at) { return in_ball(at, radius); })).empty());
        ++found;
    }
    EXPECT_GT(found, 30u);
}

TEST(SparseStructures, UnevenStepsAreSparseToo) {
    const auto painted = [](std::uint32_t k) { return k == 9 || k == 12 || k == 18 || k == 21 || k == 28; };
    const auto sparse =
        find_sparse_structures(map_of([&](auto at) { return in_ball(at, 14) && painted(at[2]); }));
    ASSERT_EQ(sparse.size(), 1u);
    EXPECT_EQ(sparse[0].slices, 5u);
}

// A slip of the brush, or one slice painted beside another, is no reason for plates in silence.
TEST(SparseStructures, AStrayVoxelOrOneSliceMoreChangesNothing) {
    const auto with = [](std::uint32_t more, bool whole) {
        return find_sparse_structures(map_of([=](auto at) {
            const bool painted = at[2] % 4 == 1 || (at[2] == more && (whole || (at[0] == 20 && at[1] == 20)));
            return in_ball(at, 14) && painted;
        }));
    };
    for (const bool whole : {false, true}) {
        for (const std::uint32_t more : {10u, 14u, 18u, 22u}) {
            const auto sparse = with(more, whole);
            ASSERT_EQ(sparse.size(), 1u) << more << whole;
            EXPECT_EQ(sparse[0].axis, 2u);
        }
    }
}

// Each axis of the patient has a voxel axis of its own, however the image lies.
TEST(SparseStructures, AnObliqueImageIsTakenAlongTheAxisThatTheMessageNames) {
    for (const double degrees : {0.0, 20.0, 45.0, 70.0, 90.0, 135.0}) {
        const double c = std::cos(degrees * std::numbers::pi / 180),
                     s = std::sin(degrees * std::numbers::pi / 180);
        LabelMap map = map_of([](auto at) { return in_ball(at, 14) && at[0] % 5 == 2; });
        map.geometry.step = {Vec3{c, s, 0}, Vec3{-s, c, 0}, Vec3{0, 0, 1}};
        std::size_t joined = 0;
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            TraceOptions options;
            options.axis = axis;
            options.between_sparse = BetweenSparse::interpolated;
            RunContext context;
            const auto traced = trace_contours(map, nullptr, 0, options, context);
            ASSERT_TRUE(traced.ok());
            if (traced.value().kept.complete) continue;
            ++joined;
            const auto told =
                std::find_if(context.warnings.begin(), context.warnings.end(),
                             [](const Warning& warning) { return warning.code == "W-TRC-007"; });
            ASSERT_NE(told, context.warnings.end());
            EXPECT_NE(told->message.find(std::string("along ") + "xyz"[axis]), std::string::npos);
        }
        EXPECT_EQ(joined, 1u) << degrees;
    }
}

TEST(SparseStructures, OnlyTheSparseOneOfSeveralIsNamed) {
    const auto sparse = find_sparse_structures(
        map_of([&](auto at) { return !in_ball(at, 14) ? 0
                                     : at[0] < 20     ? 1
                                     : at[2] % 3 == 0 ? 2
                                                      : 0; }, 2));
    ASSERT_EQ(sparse.size(), 1u);
    EXPECT_EQ(sparse[0].structure, 1u);
}

TEST(SparseStructures, PartsThatDoNotOverlapAndFewSlicesAreNoSparseStructure) {
    // Specks on a stair: on lone slices, but nothing shows that they are one body.
    EXPECT_TRUE(find_sparse_structures(map_of([](auto at) {
                    return at[2] % 4 == 0 && at[0] / 3 == at[2] / 4 && at[1] / 3 == at[2] / 4;
                })).empty());
    EXPECT_TRUE(find_sparse_structures(map_of([](auto at) {
                    return in_ball(at, 14) && (at[2] == 15 || at[2] == 22);
                })).empty())
        << "two slices have no step of their own";
    EXPECT_TRUE(find_sparse_structures(map_of([](auto) { return 0; })).empty());
}

TEST(SparseStructures, TracingSaysWhatItMakesOfThem) {
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const LabelMap map = map_of([&](auto at) { return in_ball(at, 14) && at[axis] % 5 == 2; });
        for (const BetweenSparse between : {BetweenSparse::nothing, BetweenSparse::interpolated}) {
            TraceOptions options;
            options.axis = axis;
            options.between_sparse = between;
            RunContext context;
            const auto traced = trace_contours(map, nullptr, 0, options, context);
            ASSERT_TRUE(traced.ok());
            EXPECT_EQ(traced.value().stats.slice_axis, axis);
            EXPECT_EQ(traced.value().kept.complete, between == BetweenSparse::nothing);
            ASSERT_EQ(context.warnings.size(), 1u);
            EXPECT_EQ(context.warnings[0].code, "W-TRC-007");
            EXPECT_NE(context.warnings[0].message.find(std::string("along ") + "xyz"[axis]),
                      std::string::npos);
        }
    }
}

}  // namespace
}  // namespace anatomesh::sparse_structures_test
