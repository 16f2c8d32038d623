#include "anatomesh/live/livewire/livewire_costs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "anatomesh/live/livewire/livewire_pictures_for_test.h"

namespace anatomesh::livewire_costs_test {
namespace {

using testing::costs_of;
using testing::features_of;
using testing::picture;

double per_mm(const LivewireCosts& costs, Pixel p, StepDirection direction) {
    const Vec2 step = costs.grid.step;
    const double lengths[step_directions] = {step.x, step.y, length(step), length(step)};
    const auto d = static_cast<std::size_t>(direction);
    return costs.steps[step_directions * costs.grid.index(p) + d] * costs.mm_per_unit() / lengths[d];
}

TEST(LivewireCosts, a_step_costs_nothing_to_one_per_mm_and_exists_inside_only) {
    std::mt19937 random(1);
    for (const Vec2 step : {Vec2{1, 1}, Vec2{0.5, 1.5}, Vec2{0.1, 20}}) {
        const PictureGrid grid{{31, 23}, step};
        GreyPicture slice = picture(
            grid, [](Vec2 p) { return p.x * std::sin(p.y); }, 3);
        for (int n = 0; n < 20; ++n) slice.pixels[random() % slice.pixels.size()] = std::nanf("");
        const LivewireCosts costs = costs_of(slice);
        for (std::uint32_t v = 0; v < grid.count(); ++v) {
            const Pixel p = grid.pixel(v);
            const bool right = p.i + 1 < 31, down = p.j + 1 < 23;
            const bool present[step_directions] = {right, down, right && down, p.i > 0 && down};
            for (std::size_t d = 0; d < step_directions; ++d) {
                ASSERT_EQ(costs.steps[step_directions * v + d] > 0, present[d]);
                // Rounding to whole units is coarse for the shorter steps of long pixels.
                ASSERT_LE(per_mm(costs, p, static_cast<StepDirection>(d)),
                          1 + 0.5 * costs.mm_per_unit() / step.x);
            }
        }
    }
}

// Turning a picture by a quarter turn turns its costs: right becomes down, and down_right becomes down_left.
TEST(LivewireCosts, turn_with_the_picture) {
    const std::uint32_t n = 33;
    const PictureGrid grid{{n, n}, {1, 1}};
    for (unsigned seed = 0; seed < 20; ++seed) {
        const GreyPicture slice = picture(
            grid, [](Vec2 p) { return 3 * p.x; }, 20, seed);
        GreyPicture turned = slice;  // pixel (i, j) goes to (n - 1 - j, i)
        for (std::uint32_t j = 0; j < n; ++j) {
            for (std::uint32_t i = 0; i < n; ++i)
                turned.pixels[grid.index({n - 1 - j, i})] = slice.pixels[grid.index({i, j})];
        }
        const LivewireCosts a = costs_of(slice), b = costs_of(turned);
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            for (std::uint32_t i = 0; i + 1 < n; ++i) {
                ASSERT_NEAR(per_mm(a, {i, j}, StepDirection::right),
                            per_mm(b, {n - 1 - j, i}, StepDirection::down), 2e-3);
                ASSERT_NEAR(per_mm(a, {i, j}, StepDirection::down),
                            per_mm(b, {n - 2 - j, i}, StepDirection::right), 2e-3);
                ASSERT_NEAR(per_mm(a, {i, j}, StepDirection::down_right),
                            per_mm(b, {n - 1 - j, i}, StepDirection::down_left), 2e-3);
            }
        }
    }
}

// Brightness, contrast and unit of length are the scanner's affair.
TEST(LivewireCosts, stay_when_grey_values_and_lengths_are_scaled) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        const GreyPicture slice = picture(
            {{40, 30}, {1, 0.5}}, [](Vec2 p) { return 5 * p.x; }, 16, seed);
        GreyPicture scaled = slice;
        for (float& value : scaled.pixels) value = 4 * value;
        scaled.grid.step = {8, 4};
        ASSERT_EQ(costs_of(slice).steps, costs_of(scaled).steps);
    }
}

// Along an edge it costs next to nothing, across it much, beside it most; reversed contrast is no continuation.
TEST(LivewireCosts, are_low_along_an_edge) {
    for (const Vec2 step : {Vec2{1, 1}, Vec2{0.5, 1.5}, Vec2{1.4, 0.7}}) {
        const PictureGrid grid{{60, 60}, step};
        const LivewireCosts costs =
            costs_of(picture(grid, [&](Vec2 p) { return p.x < 29.6 * step.x ? 0.0 : 100.0; }));
        for (std::uint32_t j = 10; j < 50; ++j) {
            const double on = std::min(per_mm(costs, {29, j}, StepDirection::down),
                                       per_mm(costs, {30, j}, StepDirection::down));
            EXPECT_LT(on, 0.02);
            EXPECT_GT(per_mm(costs, {29, j}, StepDirection::right), 0.4);
            EXPECT_GT(per_mm(costs, {15, j}, StepDirection::down), 0.99);
        }
    }
}

// Where the bright side changes, an edge ends: a dark line has two edges, and a wire does not hop between them.
TEST(LivewireCosts, directions_are_opposed_where_the_bright_side_changes) {
    const PictureGrid grid{{61, 41}, {1, 1}};
    const EdgeFeatures features =
        features_of(picture(grid, [](Vec2 p) { return std::abs(p.x - 30) < 1.5 ? 0.0 : 100.0; }));
    RunContext context;
    const LivewireCosts costs =
        make_livewire_costs(features, nullptr, {{.zero_crossing = 0, .gradient_magnitude = 0}, {}}, context)
            .value();
    for (std::uint32_t j = 0; j + 1 < 41; ++j) {
        // The columns beside the line's middle slope to opposite sides, and all steps between them are diagonal.
        EXPECT_LT(per_mm(costs, {29, j}, StepDirection::down), 0.01);
        EXPECT_LT(per_mm(costs, {31, j}, StepDirection::down), 0.01);
        EXPECT_LT(per_mm(costs, {28, j}, StepDirection::down_right), 0.51);
        EXPECT_NEAR(per_mm(costs, {30, j}, StepDirection::down_right), 1, 1e-3);
    }
    const EdgeFeatures ridge =
        features_of(picture(grid, [](Vec2 p) { return std::abs(p.x - 29.5) < 1.5 ? 100.0 : 0.0; }));
    const LivewireCosts on_ridge =
        make_livewire_costs(ridge, nullptr, {{.zero_crossing = 0, .gradient_magnitude = 0}, {}}, context)
            .value();
    EXPECT_NEAR(per_mm(on_ridge, {29, 20}, StepDirection::down_right), 1, 1e-3);
    EXPECT_NEAR(per_mm(on_ridge, {28, 20}, StepDirection::down_right), 0.5, 1e-2);
}

TEST(LivewireCosts, the_most_is_paid_at_pixels_without_a_value) {
    const PictureGrid grid{{20, 20}, {1, 1}};
    GreyPicture slice = picture(grid, [](Vec2 p) { return p.x < 9.6 ? 0.0 : 100.0; });
    slice.pixels[grid.index({10, 10})] = std::nanf("");
    const LivewireCosts costs = costs_of(slice);
    for (const StepDirection d :
         {StepDirection::right, StepDirection::down, StepDirection::down_right, StepDirection::down_left})
        EXPECT_NEAR(per_mm(costs, {10, 10}, d), 1, 1e-4);
    EXPECT_NEAR(per_mm(costs, {10, 9}, StepDirection::down), 1, 1e-4);
    EXPECT_NEAR(per_mm(costs, {9, 10}, StepDirection::right), 1, 1e-4);
}

// The weight of one feature alone shows that feature.
TEST(LivewireCosts, weights_choose_the_features) {
    const PictureGrid grid{{40, 160}, {1, 1}};
    const EdgeFeatures features = features_of(picture(grid, [](Vec2 p) {
        return p.x < 15.5 ? 0.0 : p.y < 80 ? 100.0 : 50.0;
    }));
    RunContext context;
    const auto with = [&](LivewireWeights weights) {
        return make_livewire_costs(features, nullptr, {weights, {}}, context).value();
    };
    const LivewireCosts direction = with({0, 2, 0}), magnitude = with({0, 0, 0.1}),
                        crossing = with({7, 0, 0});
    EXPECT_LT(per_mm(direction, {15, 5}, StepDirection::down), 0.01);
    EXPECT_NEAR(per_mm(direction, {15, 5}, StepDirection::right), 1, 0.01);
    EXPECT_NEAR(per_mm(direction, {15, 5}, StepDirection::down_right), 0.5, 0.01);
    EXPECT_NEAR(per_mm(magnitude, {15, 120}, StepDirection::down), 0.5, 0.03);
    EXPECT_LT(per_mm(magnitude, {15, 10}, StepDirection::down), 0.03);
    const double one = per_mm(crossing, {15, 8}, StepDirection::down);
    const double other = per_mm(crossing, {16, 8}, StepDirection::down);
    EXPECT_LT(std::min(one, other), 1e-4);
    EXPECT_NEAR(per_mm(crossing, {5, 8}, StepDirection::down), 1, 1e-3);
}

}  // namespace
}  // namespace anatomesh::livewire_costs_test
